#include "viewers/saleae/settings.hpp"

#include <AnalyzerHelpers.h>

namespace logic {

namespace {

constexpr unsigned csv_export = 0;

}  // namespace

Settings::Settings() {
  ma_field_.SetTitleAndTooltip("MA", "Clock of the master");
  slo_field_.SetTitleAndTooltip("SLO", "Data of the encoder");
  format_field_.SetTitleAndTooltip(
      "Frame format", "Items in line order (pos26,nE,nW,crc6), a name of 'biss encoders', or none");
  ma_inverted_field_.SetTitleAndTooltip("MA inverted", "The channel shows the inverse of MA");
  ma_inverted_field_.SetCheckBoxText("MA is inverted");
  slo_inverted_field_.SetTitleAndTooltip("SLO inverted", "The channel shows the inverse of SLO");
  slo_inverted_field_.SetCheckBoxText("SLO is inverted");
  show();
  AddInterface(&ma_field_);
  AddInterface(&slo_field_);
  AddInterface(&format_field_);
  AddInterface(&ma_inverted_field_);
  AddInterface(&slo_inverted_field_);
  AddExportOption(csv_export, "Export the rows as CSV");
  AddExportExtension(csv_export, "CSV", "csv");
  announce_channels();
}

void Settings::show() {
  ma_field_.SetChannel(ma_);
  slo_field_.SetChannel(slo_);
  format_field_.SetText(format_.c_str());
  ma_inverted_field_.SetValue(rows_.ma_inverted);
  slo_inverted_field_.SetValue(rows_.slo_inverted);
}

void Settings::announce_channels() {
  ClearChannels();
  AddChannel(ma_, "MA", ma_ != UNDEFINED_CHANNEL);
  AddChannel(slo_, "SLO", slo_ != UNDEFINED_CHANNEL);
}

bool Settings::apply_format() {
  const auto applied = biss::saleae::set_format(rows_, format_);
  if (!applied) SetErrorText(applied.error().c_str());
  return applied.has_value();
}

bool Settings::SetSettingsFromInterfaces() {
  const Channel ma = ma_field_.GetChannel();
  const Channel slo = slo_field_.GetChannel();
  if (ma == UNDEFINED_CHANNEL || slo == UNDEFINED_CHANNEL || ma == slo) {
    SetErrorText("Choose two different channels for MA and SLO.");
    return false;
  }
  rows_.ma_inverted = ma_inverted_field_.GetValue();
  rows_.slo_inverted = slo_inverted_field_.GetValue();
  format_ = format_field_.GetText();
  if (!apply_format()) return false;
  ma_ = ma;
  slo_ = slo;
  announce_channels();
  return true;
}

void Settings::LoadSettings(const char* settings) {
  SimpleArchive archive;
  archive.SetString(settings);
  const char* format = nullptr;
  const bool whole = (archive >> ma_) && (archive >> slo_) && (archive >> &format) &&
                     (archive >> rows_.ma_inverted) && (archive >> rows_.slo_inverted);
  format_ = whole && format != nullptr ? format : "";
  // An archive of another version may hold anything.
  if (!apply_format()) format_.clear();
  announce_channels();
  show();
}

const char* Settings::SaveSettings() {
  SimpleArchive archive;
  archive << ma_;
  archive << slo_;
  archive << format_.c_str();
  archive << rows_.ma_inverted;
  archive << rows_.slo_inverted;
  return SetReturnString(archive.GetString());
}

}  // namespace logic
