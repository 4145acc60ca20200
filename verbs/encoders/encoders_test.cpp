#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "biss/catalogue/catalogue.hpp"
#include "biss/safety/configurations.hpp"
#include "cli/test_verb_harness.hpp"

namespace biss::verbs {
namespace encoders_test {

using nlohmann::json;
using testing::HasSubstr;

Ran encoders(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "encoders");
  return run_verb(arguments);
}

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Encoders, Table_HasALineForEachAndFitsATerminal) {
  const Ran ran = encoders({});
  EXPECT_EQ(ran.status, ExitStatus::done);
  const auto lines = lines_of(ran.out);
  EXPECT_EQ(lines.size(), catalogue.size() + 3 + 1 + safety_configurations.size() + 3);
  for (const std::string& line : lines) {
    if (line.starts_with("─")) continue;  // three bytes a column
    EXPECT_LE(line.size(), 100U) << line;
  }
}

TEST(Encoders, Table_ListsTheSafetyConfigurationsToo) {
  const std::string out = encoders({}).out;
  for (const SafetyConfiguration& each : safety_configurations) {
    EXPECT_THAT(out, HasSubstr(fmt::format("\n{} ", each.name)));
  }
  EXPECT_THAT(out, testing::ContainsRegex("rsh  .* 13 +62.50\n"));
  EXPECT_THAT(out, testing::ContainsRegex("fortis-fs-36-28-1nm .* - +31.25\n"));
  const Ran one = encoders({"rlh"});
  EXPECT_EQ(one.status, ExitStatus::done);
  EXPECT_THAT(one.out, HasSubstr("\nrlh  "));
  EXPECT_EQ(lines_of(one.out).size(), 4U);
  EXPECT_EQ(encoders({"rlh", "--to", "csv"}).status, ExitStatus::data_failed);
}

TEST(Encoders, ClockThatIsNotStated_IsADash) {
  EXPECT_THAT(encoders({}).out, testing::ContainsRegex("jtw-24 .* -  +3\n"));
}

TEST(Encoders, Objects_CarryAllThatIsKnown) {
  const auto lines = lines_of(encoders({"--to", "jsonl"}).out);
  ASSERT_EQ(lines.size(), catalogue.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const json object = json::parse(lines[i]);
    EXPECT_EQ(object["name"], catalogue[i].name);
    EXPECT_EQ(object["format"], catalogue[i].format);
    EXPECT_EQ(object["uncertain"].get<std::string>().empty(), catalogue[i].certain());
  }
}

TEST(Encoders, OneName_ShowsItsTimingAndDoubts) {
  const Ran ran = encoders({"faulhaber-aemt"});
  EXPECT_THAT(ran.out, HasSubstr("static:20us"));
  EXPECT_THAT(ran.out, HasSubstr("not certain"));
  EXPECT_THAT(ran.out, HasSubstr("0x43 assumed"));
  EXPECT_THAT(encoders({"resolute-26"}).out, HasSubstr("3.225 us to 3.275 us"));
  EXPECT_THAT(encoders({"lenz-b3"}).out, HasSubstr("4 clocks"));
  EXPECT_EQ(lines_of(encoders({"lenz-b3", "--to", "csv"}).out).size(), 2U);
}

TEST(Encoders, WhatIsInferredOrCalculated_IsShown) {
  const std::string rotary = encoders({"resolute-18"}).out;
  EXPECT_THAT(rotary, HasSubstr("4.94 arcsec (calculated)"));
  EXPECT_THAT(rotary, HasSubstr("which of 18, 26, 32 and 36 bits are rotary: inferred"));
  const std::string linear = encoders({"resolute-linear-26"}).out;
  EXPECT_THAT(linear, HasSubstr("pos26,nE,nW,crc6;cds0"));
  EXPECT_THAT(linear, HasSubstr("50 nm, range 3.36 m (calculated)"));
  EXPECT_THAT(linear, HasSubstr("50 nm with 26 bits is stated for FORTiS only: inferred"));
  EXPECT_THAT(encoders({"fortis-36"}).out, HasSubstr("1 nm or 10 nm is not stated"));
  EXPECT_THAT(encoders({"fortis-36", "--to", "csv"}).out, HasSubstr("1 nm or 10 nm is not stated"));
}

TEST(Encoders, Word_FiltersByNameMakerAndFamilyInAnyCase) {
  for (const char* word : {"renishaw", "RENISHAW", "nisha"}) {
    const auto lines = lines_of(encoders({word, "--to", "csv"}).out);
    EXPECT_EQ(lines.size(), 1U + renishaw_encoders.size()) << word;
  }
  const auto fortis = lines_of(encoders({"fortis", "--to", "jsonl"}).out);
  EXPECT_EQ(fortis.size(), 4U);
  for (const std::string& line : fortis) EXPECT_THAT(line, HasSubstr("FORTiS"));
  EXPECT_EQ(lines_of(encoders({"inductive", "--to", "csv"}).out).size(), 2U);
  const std::string table = encoders({"renishaw"}).out;
  EXPECT_THAT(table, HasSubstr("\nresolute-26 "));
  EXPECT_THAT(table, HasSubstr("\nfortis-fs-36-28-1nm "));
  EXPECT_THAT(table, testing::Not(HasSubstr("lenz")));
  EXPECT_THAT(table, testing::Not(HasSubstr("\nrsm ")));
}

TEST(Encoders, WordWithoutMatch_Exits1WithASuggestion) {
  const Ran ran = encoders({"lens-b3"});
  EXPECT_EQ(ran.status, ExitStatus::data_failed);
  EXPECT_EQ(ran.out, "");
  EXPECT_EQ(ran.err,
            "biss: no encoder with 'lens-b3' in its name, maker or family; did you mean lenz-b3? "
            "('biss encoders' lists all)\n");
}

// The list of encoders from which the catalogue was made, if it is available.

using Row = std::map<std::string, std::string>;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      cells.emplace_back();
    } else {
      cells.back().push_back(c);
    }
  }
  return cells;
}

std::vector<Row> read_rows(const std::filesystem::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const auto names = cells_of(line);
  std::vector<Row> rows;
  while (std::getline(file, line)) {
    const auto cells = cells_of(line);
    Row row;
    for (std::size_t i = 0; i < names.size() && i < cells.size(); ++i) row[names[i]] = cells[i];
    rows.push_back(row);
  }
  return rows;
}

// `12`, `12-14`, `12 or 13`, `0/12/24`, `28 (in all)`.
std::set<unsigned> widths_of(const std::string& cell) {
  std::set<unsigned> widths;
  const std::string text = cell.substr(0, cell.find('('));
  for (std::size_t at = 0; at < text.size();) {
    if (text[at] < '0' || text[at] > '9') {
      ++at;
      continue;
    }
    const char before = at == 0 ? ' ' : text[at - 1];
    std::size_t digits = 0;
    const auto width = static_cast<unsigned>(std::stoul(text.substr(at), &digits));
    if (before == '-') {
      for (unsigned between = *widths.rbegin(); between < width; ++between) widths.insert(between);
    }
    widths.insert(width);
    at += digits;
  }
  return widths;
}

/// The entries without a row of their own.
const std::set<std::string> inferred_entries{"resolute-linear-26", "resolute-linear-32",
                                             "resolute-linear-36"};

/// The entries made of a row; none if it states no widths, or if any width can be configured.
const std::map<std::string, std::string>& entries_by_family() {
  static const std::map<std::string, std::string> entries = {
      {"RESOLUTE rotary 18 bit", "resolute-18"},
      {"RESOLUTE rotary 26 bit", "resolute-26"},
      {"RESOLUTE rotary 32 bit", "resolute-32"},
      {"FORTiS linear 36 bit", "fortis-36"},
      {"FORTiS linear 26 bit (50 nm)", "fortis-26"},
      {"FORTiS linear 32 bit (10 nm)", "fortis-32"},
      {"RESOLUTE FS rotary (LMM) CPW", "fs-32-32"},
      {"RESOLUTE FS rotary (LMM) SPW", "fs-32-32"},
      {"RESOLUTE FS linear 50 nm (RSM) CPW", "fs-28-24"},
      {"RESOLUTE FS linear 50 nm (RSM) SPW", "fs-28-24"},
      {"RESOLUTE FS linear 1 nm (RSH) CPW", "fs-36-28"},
      {"RESOLUTE FS linear 1 nm (RSH) SPW", "fs-36-28"},
      {"FORTiS FS linear 10 nm (RSH) CPW", "fortis-fs-36-28"},
      {"FORTiS FS linear 10 nm (RSH) SPW", "fortis-fs-36-28"},
      {"IRS/SIB B3", "lenz-b3"},
      {"iC-MHM (demo configuration)", "ic-mhm"},
      {"iC-MH (demo configuration)", "ic-mh"},
      {"iC-MU", ""},
      {"iC-MU150", ""},
      {"iC-MR standard", "ic-mr-24 ic-mr-26 ic-mr-12-24 ic-mr-12-26 ic-mr-24-24 ic-mr-24-26"},
      {"iC-MR extended CRC",
       "ic-mr-crc16-24 ic-mr-crc16-26 ic-mr-crc16-12-24 ic-mr-crc16-12-26 ic-mr-crc16-24-24 "
       "ic-mr-crc16-24-26"},
      {"iC-MD", "ic-md-16 ic-md-24 ic-md-32 ic-md-48"},
      {"iC-PVS", ""},
      {"iC-TW29", ""},
      {"iC-LGC (AN21 example)", "ic-lgc"},
      {"AMM3616/4096SC", "lika-amm3616"},
      {"AMM3619/4096SC", "lika-amm3619"},
      {"SMRA 12/13/14 bit", "lika-smra-12 lika-smra-13 lika-smra-14"},
      {"SMA1/MTA1", "lika-sma1"},
      {"ASC85", "lika-asc85"},
      {"MXS2-BISS",
       "waycon-mxs2-18 waycon-mxs2-19 waycon-mxs2-20 waycon-mxs2-21 waycon-mxs2-22 "
       "waycon-mxs2-23"},
      {"MSA213C-S (BiSS/C)", "siko-msa213c"},
      {"AEMT-12/16 L", "faulhaber-aemt"},
      {"Sendix S36",
       "kuebler-s36-12 kuebler-s36-13 kuebler-s36-14 kuebler-s36-15 kuebler-s36-16 "
       "kuebler-s36-17 kuebler-s36-18 kuebler-s36-19 kuebler-s36-20 kuebler-s36-21 "
       "kuebler-s36-22 kuebler-s36-23"},
      {"GBPAS/GBPAH/GBPAW", ""},
      {"EFL580", ""},
      {"BML (BiSS C heads)", ""},
      {"ACURO AC36 1213", "hengstler-ac36"},
      {"AS50 18 bit", "as50-18"},
      {"AS50 10/18 bit", "as50-10-18"},
      {"AS37-H39B-B", "broadcom-as37"},
      {"24 bit", "jtw-24"},
      {"26 bit", "jtw-26"},
      {"AksIM-2", "aksim2-18 aksim2-19 aksim2-20"},
      {"12 bit BiSS-C", "moons-12"},
      {"24 bit multiturn", "xscene-24"},
      {"SFC-LACI built-in encoder", "festo-sfc-laci"},
      {"TI safety demo encoder", "ti-safety-demo"},
  };
  return entries;
}

// `low=error`; an empty cell or another text: the flag and its doubt are the entry's own.
void expect_flag(const std::string& cell, const FlagField& flag, std::string_view name) {
  if (!cell.starts_with("low=") && !cell.starts_with("high=")) return;
  EXPECT_TRUE(flag.present) << name;
  EXPECT_EQ(flag.active_high, cell.starts_with("high=")) << name;
}

// An empty cell is not stated: the entry names its assumption.
void expect_crc_doubts(const Row& row, const CatalogueEntry& entry) {
  const bool from_profile = row.at("crc_poly_hex").find("BP3") != std::string::npos;
  const bool both = from_profile || entry.doubts(doubt::start_and_inversion);
  EXPECT_EQ(row.at("crc_start").empty(), both || entry.doubts(doubt::start_unstated)) << entry.name;
  EXPECT_EQ(row.at("crc_inverted").empty(), both) << entry.name;
}

void expect_row(const Row& row, const std::vector<const CatalogueEntry*>& entries) {
  const std::string& family = row.at("family");
  const bool safety_word = family.ends_with(" SPW");
  const std::string& polynomial = row.at("crc_poly_hex");
  const std::string& clock = row.at("max_clock_mhz");
  std::set<unsigned> multiturn;
  std::set<unsigned> singleturn;
  for (const CatalogueEntry* entry : entries) {
    const FrameFormat format = entry->frame_format();
    const ChannelFormat& channel = format.channel_list[safety_word ? 1 : 0];
    multiturn.insert(channel.multiturn.bits);
    singleturn.insert(channel.position_bits() - channel.multiturn.bits);
    // If the maker gives no polynomial, 0x43 is assumed, and the entry names this assumption.
    const auto stated = polynomial.empty() ? 0x43U : std::stoul(polynomial, nullptr, 16);
    EXPECT_EQ(channel.crc.polynomial, stated) << entry->name;
    EXPECT_EQ(polynomial.empty(), entry->doubts(doubt::polynomial)) << entry->name;
    EXPECT_EQ(channel.life_counter.present(),
              row.at("notes").find("LC") != std::string::npos && !family.starts_with("iC-MR"))
        << entry->name;
    if (!clock.empty() && clock.find("configured") == std::string::npos) {
      EXPECT_EQ(entry->timing.clock_max, hertz(static_cast<std::uint32_t>(std::stod(clock) * 1e6)))
          << entry->name;
    } else {
      EXPECT_FALSE(entry->clock_known()) << entry->name;
    }
    expect_flag(row.at("error_bit"), channel.error, entry->name);
    expect_flag(row.at("warn_bit"), channel.warning, entry->name);
    EXPECT_TRUE(channel.crc.inverted && channel.crc.start == 0) << entry->name;
    expect_crc_doubts(row, *entry);
    const bool from_code = row.at("notes").starts_with("code");
    EXPECT_TRUE(!from_code || entry->doubts(doubt::driver)) << entry->name;
  }
  EXPECT_EQ(singleturn, widths_of(row.at("st_bits"))) << family;
  // An empty cell means that the total is given: the position is one number.
  const auto stated = widths_of(row.at("mt_bits"));
  EXPECT_EQ(multiturn, stated.empty() ? std::set<unsigned>{0} : stated) << family;
}

TEST(EncoderList, EveryRow_IsInTheCatalogueOrHasNoWidths) {
  const char* const shared = std::getenv("BISS_SHARED");
  const std::filesystem::path path = shared != nullptr
                                         ? std::filesystem::path(shared) / "spec/encoders.csv"
                                         : BISS_TEST_DATA "/encoders.csv";
  ASSERT_TRUE(std::filesystem::exists(path)) << path;
  std::set<std::string> seen;
  std::size_t used = 0;
  std::size_t left_out = 0;
  for (const Row& row : read_rows(path)) {
    const auto found = entries_by_family().find(row.at("family"));
    ASSERT_NE(found, entries_by_family().end()) << row.at("family");
    std::vector<const CatalogueEntry*> entries;
    std::istringstream names(found->second);
    for (std::string name; names >> name;) {
      entries.push_back(find_encoder(name));
      ASSERT_NE(entries.back(), nullptr) << name;
      seen.insert(name);
    }
    ++(entries.empty() ? left_out : used);
    if (!entries.empty()) expect_row(row, entries);
  }
  EXPECT_EQ(used, 41U);
  EXPECT_EQ(left_out, 7U);
  EXPECT_EQ(seen.size() + inferred_entries.size(), catalogue.size());
  for (const std::string& name : inferred_entries) EXPECT_NE(find_encoder(name), nullptr) << name;
}

}  // namespace encoders_test
}  // namespace biss::verbs
