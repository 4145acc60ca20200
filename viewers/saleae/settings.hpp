// The settings in Logic 2: the two channels, their polarity, the frame format.
#pragma once

#include <AnalyzerSettings.h>

#include <string>

#include "viewers/saleae/row_reader.hpp"

namespace logic {

class Settings final : public AnalyzerSettings {
 public:
  Settings();

  bool SetSettingsFromInterfaces() override;
  void LoadSettings(const char* settings) override;
  const char* SaveSettings() override;

  Channel& ma() { return ma_; }
  Channel& slo() { return slo_; }
  const biss::saleae::RowSetup& rows() const { return rows_; }

 private:
  void show();
  bool apply_format();
  void announce_channels();

  Channel ma_ = UNDEFINED_CHANNEL;
  Channel slo_ = UNDEFINED_CHANNEL;
  std::string format_;
  biss::saleae::RowSetup rows_;

  AnalyzerSettingInterfaceChannel ma_field_;
  AnalyzerSettingInterfaceChannel slo_field_;
  AnalyzerSettingInterfaceText format_field_;
  AnalyzerSettingInterfaceBool ma_inverted_field_;
  AnalyzerSettingInterfaceBool slo_inverted_field_;
};

}  // namespace logic
