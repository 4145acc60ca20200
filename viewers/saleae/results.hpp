// The rows in Logic 2: bubbles on SLO, the data table, the export.
#pragma once

#include <AnalyzerResults.h>

#include <deque>
#include <mutex>
#include <string>

#include "viewers/saleae/row_reader.hpp"
#include "viewers/saleae/settings.hpp"

namespace logic {

class Results final : public AnalyzerResults {
 public:
  explicit Results(Settings& settings) : settings_(settings) {}

  /// Adds a row as a frame of Logic, which shows it at once.
  void add(const biss::saleae::Row& row);

  void GenerateBubbleText(U64 frame_index, Channel& channel, DisplayBase base) override;
  void GenerateExportFile(const char* file, DisplayBase base, U32 export_type) override;
  void GenerateFrameTabularText(U64 frame_index, DisplayBase base) override;
  void GeneratePacketTabularText(U64 packet, DisplayBase base) override;
  void GenerateTransactionTabularText(U64 transaction, DisplayBase base) override;

 private:
  struct Texts {
    std::string csv;
    std::string brief;
    std::string full;
  };

  Texts texts_of(U64 frame_index);

  Settings& settings_;
  // Logic draws in another thread than the thread that decodes.
  std::mutex mutex_;
  std::string heading_ = "\n";
  std::deque<Texts> rows_;
  std::uint64_t end_ = 0;
};

}  // namespace logic
