#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <set>
#include <sstream>

#include "biss/catalogue/catalogue.hpp"
#include "cli/test_verb_harness.hpp"
#include "verbs/settings/exchange.hpp"
#include "verbs/settings/masters.hpp"

namespace biss::verbs {
namespace settings_test {

using testing::HasSubstr;

Ran settings(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "settings");
  return run_verb(arguments);
}

// `KEY=VALUE` texts.
std::vector<std::string> texts_of(const std::vector<Setting>& settings) {
  std::vector<std::string> texts;
  for (const Setting& each : settings) {
    if (each.value != "?")
      texts.push_back(fmt::format("{}={}", each.rows.front()->key, each.value));
  }
  return texts;
}

std::vector<std::string> words_of(const std::string& text) {
  std::vector<std::string> words;
  std::istringstream in(text);
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

FrameFormat format(const std::string& text) { return parse_format(text).value(); }

std::string text(const FrameFormat& format) { return std::string(format_text(format).view()); }

std::string error_of(const Master& master, const std::vector<std::string>& texts,
                     const std::optional<FrameFormat>& expected = {}) {
  try {
    return "no error: " + text(format_of(master, texts, expected).format);
  } catch (const VerbError& error) {
    EXPECT_EQ(error.status, ExitStatus::usage);
    return error.text;
  }
}

// ---- Examples of the makers

// Settings that makers and users publish, by the sources that masters.txt names. The two frames
// are a RESOLUTE of 26 bits at 10 MHz and an encoder of 12 and 19 bits.
struct Example {
  const char* master;
  const char* format;
  const char* clock;
  const char* settings;
};
constexpr const char* f26 = "pos26,nE,nW,crc6";
constexpr const char* f31 = "mt12,st19,nE,nW,crc6";
const Example examples[] = {
    {"el5042", f26, "10MHz",
     "80p8:11=0x43 80p8:03=1 80p8:02=0 80p8:13=0 80p8:14=0 80p8:15=0 80p8:16=26 80p8:17=0 "
     "80p8:18=0"},
    {"el5042", f31, "", "80p8:15=12 80p8:16=19"},
    {"ax8000-rotary", f26, "", "32EF:03=67108864 32EF:04=1"},
    {"ax8000-rotary", f31, "", "32EF:03=524288 32EF:04=4096"},
    {"ax8000-linear", f26, "10MHz", "32EF:05=26 32EF:0A=10000"},
    {"ax5000-rotary", f31, "",
     "Bit_resolution_singleturn_position=19 Bit_resolution_multiturn_position=12"},
    {"ax5000-linear", "pos36,nE,nW,crc6", "5MHz",
     "Bit_resolution_singleturn_position=36 Bit_resolution_multiturn_position=16 "
     "Number_of_clockcycles_multiturn_position=0 Max_clock_speed=5000"},
    {"akd2g-linear", f26, "", "FB1.BITS=26"},
    {"akd2g-rotary", f31, "", "FB1.MULTITURNBITS=12"},
    {"keb-f5", f31, "", "Ec.01=59 Ec.44=19 Ec.53=12"},
    {"nxp-biss", f31, "", "dataLen=33 errWarLen=2 mtLen=12 stLen=19 crcPoly=0x43"},
    {"dspic33a", "pos26,nE,nW", "", "B1CLTCON0=0x0000005B"},
    {"dspic33a", f26, "500kHz", "SFREQ=17"},
    {"dspic33a", f26, "100kHz", "SFREQ=25"},
    {"ecmc", f26, "10MHz", "ST_BITS=26 CLK_FRQ_KHZ=10000"},
    {"ecmc", f31, "", "MT_BITS=12 ST_BITS=19"},
    {"festo-cmmt-st", f26, "6MHz", "0x2130:7D=8 0x21A2:01=26 0x21A2:0C=6000000 0x21A2:19=0"},
    {"linuxcnc", f26, "10MHz", "biss_chan_0=crc%6uwarn%1berror%1bpos%26e frequency-khz=10000"},
    {"linuxcnc", f31, "", "biss_chan_0=crc%6uwarn%1berror%1bpos%31me"},
    {"galil", f26, "2.7MHz", "SSA=1,26,26,0<4"},
    {"galil", f31, "2.7MHz", "SSA=1,31,19,0<4"},
    {"galil", f26, "500kHz", "SSA=1,26,26,0<26"},
    {"geo-brick", "pos18,nE,nW,crc6", "1MHz", "global=$63000B channel=$211492"},
    {"geo-brick", f26, "10MHz", "global=$09000B channel=$21149A"},
    {"geo-brick", f31, "2.5MHz", "global=$27000B channel=$21149F"},
    {"power-brick", f26, "", "SerialEncCmd=$21109A"},
    {"power-brick", f31, "", "SerialEncCmd=$21109F"},
    {"akd", f26, "", "FB1.SELECT=34 FB1.BISSBITS=26"},
    {"akd", f31, "", "FB1.SELECT=34 FB1.BISSBITS=31"},
    {"synapticon", f26, "",
     "0x2110:09=26 0x2110:10=0 0x2110:12=26 0x2110:13=0 0x2110:14=36 0x2110:15=67 0x2110:16=20"},
    {"synapticon", f31, "",
     "0x2110:09=31 0x2110:10=12 0x2110:11=0 0x2110:12=19 0x2110:13=12 0x2110:15=67"},
    {"novanta", f26, "",
     "FBK_BISS1_SSI1_FRAME_SIZE=34 FBK_BISS1_SSI1_POS_BITS=26 FBK_BISS1_SSI1_POS_ST_BITS=26 "
     "FBK_BISS1_SSI1_POS_START_BIT=8"},
    {"novanta", "pos28,nE,nW,crc6", "", "FBK_BISS1_SSI1_FRAME_SIZE=36"},
    {"novanta", f31, "",
     "FBK_BISS1_SSI1_FRAME_SIZE=39 FBK_BISS1_SSI1_POS_BITS=31 FBK_BISS1_SSI1_POS_ST_BITS=19 "
     "FBK_BISS1_SSI1_POS_START_BIT=8"},
    {"moteus", f26, "1MHz",
     "aux1.bissc.rate_hz=1000000 aux1.bissc.data_bits=26 aux1.bissc.crc_bits=6 cpr=67108864"},
    {"moteus", f31, "", "aux1.bissc.data_bits=31"},
    {"openffboard", f26, "1.3MHz", "bits=26 speed=2"},
    {"ti-am243x", f26, "10MHz", "single_turn_len=26 multi_turn_len=0 baud=10"},
    {"ti-am243x", f31, "", "single_turn_len=19 multi_turn_len=12"},
    {"dspic33a", f26, "10MHz", "B1CLTCON0=0x0000065B SFREQ=0"},
    {"dspic33a", f31, "", "B1CLTCON0=0x00000660"},
    {"ic-mb3", f26, "", "SDLEN=27 INVCRCS=1 SENSCRCPOLY=0x21"},
    {"biss1sl", "pos12,nE,nW,crc6", "2MHz",
     "eBISS_SCD_LENGTH=20 CRC_POLY=0x43 CRC_INVERT=1 eBISS_FREQ_SCD=4"},
    {"biss1sl", f26, "10MHz", "eBISS_SCD_LENGTH=34 eBISS_FREQ_SCD=0"},
    {"biss1sl", f31, "", "eBISS_SCD_LENGTH=39"},
    {"agito", f26, "", "AEncType=6 AEncAbsBits=26"},
    {"agito", f31, "", "AEncAbsBits=31"},
};

TEST(Settings, PublishedExamples_ArePrinted) {
  for (const Example& each : examples) {
    SCOPED_TRACE(fmt::format("{} {}", each.master, each.format));
    LineTimes times;
    if (*each.clock != '\0') times.clock = parse_rate(each.clock).value();
    const auto made = settings_for(master_of(each.master), format(each.format), times);
    ASSERT_TRUE(made) << made.error();
    std::vector<std::string> texts = texts_of(*made);
    for (std::string& word : texts) std::replace(word.begin(), word.end(), ' ', '_');
    EXPECT_THAT(texts, testing::IsSupersetOf(words_of(each.settings)));
  }
}

// What a value does, or why it is not certain, is in the settings and in what comes back from them.
TEST(Settings, DoubtsOfAValue_AreNamed) {
  struct Doubt {
    const char* master;
    const char* settings;
    const char* doubt;
    const char* open;
  };
  const Doubt doubts[] = {
      {"el5042", ":15=0 :16=26", "", ""},
      {"el5042", ":15=0 :16=26 :11=0x97", "80p8:11: only 0x43 is certain", "polynomial: crc7:0x97"},
      {"ecmc", "MT_BITS=0 ST_BITS=26 CRC_POLY=0x97", "CRC_POLY: only 0x43 is certain",
       "polynomial: crc7:0x97 is not usual"},
      {"el5042", ":15=0 :16=26 :11=0x12F", "80p8:11: only 0x43 is certain", ""},
      {"el5042", ":15=0 :16=26 :02=1", "80p8:02: 1: the drive no longer sees the error bit",
       "status: "},
      {"ecmc", "MT_BITS=0 ST_BITS=26 DIS_STAT_BITS=1", "no longer sees the error bit", "status: "},
      {"el5042", ":15=0 :16=26 :01=1", "80p8:01: 1: the position is negated", ""},
      {"el5042", ":15=0 :16=26 :12=90", "80p8:12: 5 V is the default", ""},
      {"galil", "SSA=1,-26,26,0<4", "a negative n1", ""},
      {"festo-cmmt-st", "0x21A2:01=26 0x21A2:02=0", "",
       "crc: 0x43, start 0, inverted is assumed: no source"},
      {"agito", "AEncAbsBits=26", "", "status: nE,nW is assumed: no source"},
      {"akd", "FB1.BISSBITS=26", "", "status: nE,nW is assumed: no source"},
      {"biss1sl", "eBISS_SCD_LENGTH=34 CRC_POLY=0x59 CRC_INVERT=1", "",
       "polynomial: crc6:0x59 is not usual"},
  };
  for (const Doubt& each : doubts) {
    SCOPED_TRACE(fmt::format("{} {}", each.master, each.settings));
    const Found found = format_of(master_of(each.master), words_of(each.settings), {});
    const std::string all =
        fmt::format("{} {}", fmt::join(found.doubts, " "), fmt::join(found.open, " "));
    EXPECT_THAT(all, HasSubstr(each.doubt));
    EXPECT_THAT(all, HasSubstr(each.open));
    if (*each.open == '\0') {
      EXPECT_THAT(all, testing::Not(HasSubstr("polynomial: ")));
    }
  }
  EXPECT_THAT(settings({"-f", "pos26,E,W,crc6", "--for", "el5042"}).out,
              HasSubstr("the drive no longer sees the error bit"));
  EXPECT_THAT(settings({"-f", "pos26,E,W,crc6", "--for", "ecmc", "--to", "jsonl"}).out,
              HasSubstr("the drive no longer sees the error bit"));
  const std::string all =
      settings({"-f", "pos26,E,W,crc6", "--for", "all", "--clock", "1MHz", "--to", "csv"}).out;
  for (const char* const text :
       {"80p8:02: 1: the drive no longer sees the error bit",
        "ACK: Max calculation time: give --ack-max", "VESC does not see the error bit",
        "clock: no setting for it is known"}) {
    EXPECT_THAT(all, HasSubstr(text));
  }
  EXPECT_THAT(settings({"-f", f26, "--for", "agito"}).out,
              testing::ContainsRegex("assumed +crc6:0x43, start 0, inverted: no source"));
}

// Two ways to write the same parameter or polynomial.
TEST(Settings, SameSettingsInOtherWords_AreTheSame) {
  struct Words {
    const char* master;
    const char* settings;
    const char* format;
  };
  const Words same[] = {
      {"EL5042", "8008:15=12 8008:16=19", f31},
      {"el5042", "80A8:15=12 80a8:16=19", f31},
      {"ax8000-linear", "36ef:05=26", f26},
      {"akd2g-linear", "FB2.BITS=26", f26},
      {"galil", "SSB=1,31,19,0<4", f31},
      {"synapticon", "0x2112:09=26 0x2112:12=26", f26},
      {"linuxcnc", "biss_chan_3=crc%6uwarn%1berror%1bpos%26e", f26},
      {"ic-mb4", "0xC0=0x5B 0xC1=0x06", f26},
      {"ic-mb4", "0xC0=0x5B 0xC1=0xA1", f26},
      {"dspic33a", "B1CLTCON0=0x0000A15B", f26},
      {"dspic33a", "B1CLTCON0=0x0000005B", "pos26,nE,nW"},
      {"ax5000-linear", "Bit resolution singleturn position", f26},
      {"geo-brick", "channel=$21149A global=$63080B", f26},
  };
  for (const Words& each : same) {
    SCOPED_TRACE(fmt::format("{} {}", each.master, each.settings));
    auto words = words_of(each.settings);
    if (std::string_view(each.settings).starts_with("Bit")) {
      words = {fmt::format("{}=26", each.settings), "Bit resolution multiturn position=16"};
    }
    const Master& master = master_of(each.master);
    EXPECT_EQ(text(format_of(master, words, {}).format), each.format);
    EXPECT_EQ(text(format_of(master, words, format(each.format)).format), each.format);
  }
}

// PandABlocks has values with spaces.
TEST(Settings, ClockAsPeriod_IsInMicroseconds) {
  const auto made = settings_for(master_of("pandablocks"), format(f26), {.clock = megahertz(10)});
  EXPECT_THAT(texts_of(*made),
              testing::IsSupersetOf({"PROTOCOL=BISS", "CLK_PERIOD=0.1", "BITS=26"}));
  EXPECT_EQ(format_of(master_of("pandablocks"), texts_of(*made), {}).times.clock, megahertz(10));
}

TEST(Settings, PublishedLimits_AreRefused) {
  const auto why = [](const char* master, const char* text, std::optional<Hertz> clock = {}) {
    const auto made = settings_for(master_of(master), format(text), {.clock = clock});
    return made ? "settings" : made.error();
  };
  // RESOLUTE at 10 MHz is not possible with Festo, Galil, moteus.
  EXPECT_THAT(why("festo-cmmt-st", f26, megahertz(10)), HasSubstr("clock: "));
  EXPECT_THAT(why("galil", f26, megahertz(10)), HasSubstr("the next lower one is 2.7 MHz"));
  EXPECT_THAT(why("moteus", f26, megahertz(10)), HasSubstr("the next lower one is 1 MHz"));
  EXPECT_THAT(why("el5042", f26, megahertz(4)), HasSubstr("the next lower one is 3.333333 MHz"));
  EXPECT_THAT(why("el5042", f26, kilohertz(100)), HasSubstr("all its clocks are higher"));
  // 31 bits are not possible with VESC and OpenFFBoard.
  EXPECT_THAT(why("vesc", f31), HasSubstr("position: "));
  EXPECT_THAT(why("openffboard", f31), HasSubstr("position: "));
  EXPECT_THAT(why("geo-brick", "pos11,nE,nW,crc6"), HasSubstr("12 to 40"));
  EXPECT_THAT(why("galil", "pos39,nE,nW,crc6"), HasSubstr("1 to 38"));
}

TEST(Settings, FormatsThatAMasterCannotRead_AreRefusedByName) {
  struct Refused {
    const char* master;
    const char* format;
    const char* why;
  };
  const Refused refused[] = {
      {"el5042", "pos36,nE,nW,crc6+pos28,nE,nW,lc6,crc16", "chain: "},
      {"el5042", "pos26,nE,nW,crc6:0x43:0x2A", "crc_start: the start value is 0x2A"},
      {"ti-am243x", "pos26,nE,nW,crc5", "crc_polynomial: "},
      {"ti-am243x", "pos26,nE,nW,crc6:0x59", "crc_polynomial: "},
      {"akd", "pos26,nE,nW,crc6:plain", "crc_plain: "},
      {"akd", "pos26,nE,nW", "crc_polynomial: no CRC"},
      {"dspic33a", "pos26,nE,nW,crc6:plain", "crc_plain: "},
      {"ic-mb4", "pos26,nE,nW", "crc_polynomial: no CRC; the master has only frames with one"},
      {"ax5000-rotary", "pos26,nE,nW", "crc_polynomial: no CRC"},
      {"novanta", "pos26,nE,nW", "crc_polynomial: no CRC; crc6:0x43 is assumed for this master"},
      {"novanta", "pos26,nE,nW,crc8", "crc_polynomial: crc8:0x12F; crc6:0x43 is assumed"},
      {"akd2g-linear", "pos26,nE,nW,crc6:plain", "crc_plain: the CRC is not inverted; an inverted"},
      {"agito", "pos26,nE,nW,crc6:0x43:0x1", "crc_start: the start value is 0x1; 0 is assumed"},
      {"keb-f6", "pos26,E,W,crc6", "status: before the CRC, nE,nW is assumed"},
      {"akd", "pos26,E,W,crc6", "status: before the CRC, nE,nW is assumed"},
      {"ax8000-rotary", "pos26,nE,nW,crc6:0x43:0x2A", "crc_start: the start value is 0x2A"},
      {"ax5000-linear", "pos26,nE,nW,crc6:0x43:0x2A", "crc_start: the start value is 0x2A"},
      {"ax5000-linear", "mt12,st13,nE,nW,crc6", "multiturn: "},
      {"akd2g-linear", "mt12,st13,nE,nW,crc6", "multiturn: "},
      {"ax8000-rotary", "mt12,st29,nE,nW,crc6", "position: singleturn and multiturn is 41"},
      {"ax8000-linear", "pos41,nE,nW,crc6", "position: "},
      {"linuxcnc", "pos26,nW,nE,crc6", "status: before the CRC, not in this table"},
      {"linuxcnc", "pos26,E,W,crc6", "status: before the CRC, not in this table"},
      {"linuxcnc", "pos26,nE,pad1,crc6", "status: before the CRC, not in this table"},
      {"linuxcnc", "pos26:gray,nE,nW,crc6", "coding: Gray code; not in this table"},
      {"nxp-biss", "pos26,nE,nW,crc6:0x59",
       "crc_polynomial: the master has only the usual polynomial of each width"},
      {"nxp-biss", "pos26,nE,crc6", "status: errWarLen is 1; the master has only 2"},
      {"ic-mb4", "pos26,nE,nW,crc16:0x190D9:0x100", "crc_start: "},
      {"el5042", "pos26,nE,nW,crc6:reversed", "crc_error: "},
      {"synapticon", "pos26,nE,nW,crc8", "crc_polynomial: "},
      {"synapticon", "pos26,E,nW,crc6", "status: "},
      {"ti-am243x", "pos26,nE,pad1,crc6", "status: "},
      {"ti-am243x", "pos26,E,nW,crc6", "status: "},
      {"ti-am243x", "pos26,nE,crc6", "status: "},
      {"ti-am243x", "pos26,crc6", "status: "},
      {"ti-am243x", "pos26,nW,nE,crc6", "status: "},
      {"pandablocks", "pos26,pad1,nW,crc6", "status: "},
      {"keb-f5", "mt12,st19,pad1,nE,nW,crc6", "padding: "},
      {"keb-f5", "pad2,pos19,nE,nW,crc6", "padding: "},
      {"el5042", "mt12,pad1,st19,nE,nW,crc6", "padding: "},
      {"el5042", "st19,mt12,nE,nW,crc6", "arrangement: "},
      {"el5042", "nE,nW,pos19,crc6", "arrangement: "},
      {"el5042", "mt12,st20,nE,nW,lc6,crc16", "arrangement: "},
      {"el5042", "nE,nW,crc6", "arrangement: "},
      {"el5042", "pos26:lsb,nE,nW,crc6", "coding: "},
      {"el5042", "mt12:gray,st13:gray,nE,nW,crc6", "coding: "},
      {"ti-am243x", "pos26:gray,nE,nW,crc6", "coding: "},
      {"linuxcnc", "pos32,nE,nW,crc6", "position: "},
      {"linuxcnc", "pad2,pos20,nE,nW,crc6",
       "padding: 2, 0 and 0 bits before, within and after the position; not in this table"},
      {"el5042", "pad2,pos20,nE,nW,crc6",
       "padding: 2, 0 and 0 bits before, within and after the position; no parameter for it is "
       "known"},
      {"ax8000-linear", "mt12,st13,nE,nW,crc6", "multiturn: "},
  };
  for (const Refused& each : refused) {
    const auto made = settings_for(master_of(each.master), format(each.format), {});
    ASSERT_FALSE(made) << each.master << ' ' << each.format;
    EXPECT_THAT(made.error(), testing::StartsWith(each.why)) << each.master << ' ' << each.format;
  }
}

// ---- Forth and back

// The bits of the first channel as settings can have them: without the facts that are open. It
// walks over the bits itself. A position that is not divided and singleturn bits without multiturn
// bits are the same bits, and CDS is not a setting.
std::string bits_of(const FrameFormat& format, const std::vector<std::string>& open) {
  const auto is_open = [&open](const std::string& fact) {
    return std::any_of(open.begin(), open.end(),
                       [&](const std::string& each) { return each.starts_with(fact); });
  };
  const ChannelFormat& channel = format.channel_list[0];
  std::string bits;
  for (unsigned shift = channel.data_bits; shift-- > 0;) {
    const auto in = [shift](const Field& field) {
      return field.present() && shift >= field.shift && shift < unsigned{field.shift} + field.bits;
    };
    char letter = '0';
    if (in(channel.multiturn)) letter = 'm';
    if (in(channel.singleturn) || in(channel.position)) letter = 's';
    if (in(channel.life_counter)) letter = 'l';
    if (in(channel.error.place())) letter = channel.error.active_high ? 'E' : 'e';
    if (in(channel.warning.place())) letter = channel.warning.active_high ? 'W' : 'w';
    const bool position = letter == 'm' || letter == 's';
    if (is_open("turns") && position) letter = 'p';
    if (is_open("status") && shift < 2) letter = '?';
    if (is_open("arrangement")) letter = '?';
    bits += letter;
  }
  const CrcSpec& crc = channel.crc;
  if (!is_open("crc")) {
    bits += fmt::format(" {:X} {:X} {}", crc.polynomial, crc.start, bool{crc.inverted});
  }
  return bits;
}

// The format itself, but for the option cds0.
FrameFormat without_cds0(FrameFormat format) {
  format.cds0 = false;
  return format;
}

// Returns false if the master refuses the format.
bool expect_round_trip(const Master& master, const FrameFormat& format) {
  SCOPED_TRACE(fmt::format("{} {}", master.name, text(format)));
  const auto made = settings_for(master, format, {});
  if (!made) {
    const std::string cause = made.error().substr(0, made.error().find(':'));
    const auto& rows = master.parameters;
    const bool limit = std::any_of(rows.begin(), rows.end(),
                                   [&](const Parameter& row) { return row.term == cause; });
    static const std::set<std::string> causes = {
        "chain",     "crc_error", "crc_polynomial", "crc_plain",   "coding",
        "crc_start", "status",    "padding",        "arrangement", "data"};
    EXPECT_TRUE(limit || causes.contains(cause)) << made.error();
    return false;
  }
  const std::vector<std::string> texts = texts_of(*made);
  // The parameters of the position are not known.
  if (master.name == "elmo" || master.name == "akd2g-rotary") {
    EXPECT_THAT(error_of(master, texts),
                HasSubstr("not_a_format: the numbers of bits do not fit together, or are not in"));
    return true;
  }
  try {
    // The bits of CDS, and open ones, come from the format.
    EXPECT_EQ(text(format_of(master, texts, format).format), text(format));
    const Found found = format_of(master, texts, {});
    EXPECT_EQ(bits_of(found.format, found.open), bits_of(without_cds0(format), found.open));
    EXPECT_EQ(format_of(master, texts, found.format).open.size(), 0U);
    const auto again = settings_for(master, found.format, {});
    EXPECT_TRUE(again);
    const bool free = master.find("status_off") != nullptr || master.find("turns_free") != nullptr;
    if (again && !free) {
      EXPECT_EQ(texts_of(*again), texts);
    }
  } catch (const VerbError& error) {
    ADD_FAILURE() << error.text;
  }
  return true;
}

TEST(Settings, EveryEncoderOfTheCatalogue_ComesBackFromEveryMaster) {
  std::map<std::string_view, unsigned> read;
  for (const CatalogueEntry& entry : catalogue) {
    for (const Master& master : masters()) {
      read[master.name] += expect_round_trip(master, entry.frame_format()) ? 1U : 0U;
    }
  }
  // Every master reads some of them, the EL5042 all but the frames with several channels or a
  // sign-of-life counter.
  unsigned plain = 0;
  for (const CatalogueEntry& entry : catalogue) {
    const FrameFormat format = entry.frame_format();
    plain += format.channel_count == 1 && !format.channel_list[0].life_counter.present() ? 1U : 0U;
  }
  EXPECT_EQ(read["el5042"], plain);
  for (const auto& [name, count] : read) {
    std::printf("[ formats  ] %2u of %zu: %s\n", count, catalogue.size(),
                std::string(name).c_str());
    EXPECT_GT(count, 20U) << name;
  }
}

std::string random_format(std::mt19937& random) {
  const auto below = [&random](unsigned n) { return static_cast<unsigned>(random() % n); };
  std::string text;
  const auto pad = [&] {
    if (below(6) == 0) text += fmt::format("pad{},", 1 + below(4));
  };
  pad();
  if (below(2) == 0) {
    text += fmt::format("pos{}{},", 1 + below(48), below(8) == 0 ? ":gray" : "");
  } else {
    text += fmt::format("mt{},", 1 + below(20));
    pad();
    text += fmt::format("st{},", 1 + below(28));
  }
  pad();
  const char* const flags[] = {"nE,nW,", "nE,nW,",   "nE,nW,", "E,W,",
                               "E,nW,",  "nE,pad1,", "pad2,",  ""};
  text += flags[below(8)];
  const char* const crcs[] = {"crc6",      "crc6",       "crc6",
                              "crc5",      "crc8",       "crc16",
                              "crc6:0x59", "crc6:plain", "crc16:0x190D9:0x1",
                              "crc7"};
  return text + crcs[below(10)];
}

TEST(Settings, RandomFormats_ComeBackFromEveryMasterThatReadsThem) {
  std::mt19937 random(20261128);
  std::map<std::string_view, unsigned> read;
  for (unsigned i = 0; i < 1000; ++i) {
    const std::string text = random_format(random);
    const auto format = parse_format(text);
    if (!format.ok()) continue;
    for (const Master& master : masters()) {
      read[master.name] += expect_round_trip(master, *format) ? 1U : 0U;
    }
    if (HasFailure()) FAIL() << text;
  }
  for (const auto& [name, count] : read) EXPECT_GT(count, 10U) << name;
}

// ---- Wrong settings

// A value that differs by one is another format or an error, never the same format.
TEST(Settings, ValueOffByOne_IsNeverTheSameFormat) {
  unsigned others = 0;
  for (const Master& master : masters()) {
    for (const char* const text_of_format : {f26, f31, "mt4,st17,nE,nW,crc6"}) {
      const auto made = settings_for(master, format(text_of_format), {});
      if (!made) continue;
      for (std::size_t i = 0; i < made->size(); ++i) {
        const Parameter& row = *(*made)[i].rows.front();
        const bool fact = row.term != "constant" && row.term != "unknown" && row.term != "clock" &&
                          row.term != "timeout" && row.term != "busy" && row.term != "status_off" &&
                          row.term != "counts_free";
        if ((*made)[i].rows.size() > 1 || !fact || !row.names.empty()) continue;
        for (const int step : {-1, 1}) {
          auto texts = texts_of(*made);
          const auto own = std::find_if(texts.begin(), texts.end(), [&](const std::string& each) {
            return each.starts_with(std::string(row.key) + "=");
          });
          const std::string value = own->substr(row.key.size() + 1);
          const auto number = std::stoll(value, nullptr, 0) + step;
          *own = row.form == Form::hexadecimal ? fmt::format("{}=0x{:X}", row.key, number)
                                               : fmt::format("{}={}", row.key, number);
          SCOPED_TRACE(fmt::format("{} {}", master.name, *own));
          EXPECT_THAT(error_of(master, texts, format(text_of_format)),
                      testing::Not(HasSubstr("no error")));
          ++others;
        }
      }
    }
  }
  EXPECT_GT(others, 200U);
}

TEST(Settings, WrongSettings_AreNamedAndSayWhatIsAllowed) {
  struct Wrong {
    const char* master;
    const char* settings;
    const char* why;
  };
  const Wrong wrong[] = {
      {"el5042", ":15=0 :61=2", "unknown_key: ':61'"},
      {"el5042", "Multiturn=0", "the keys are 80p8:01, 80p8:02, 80p8:03"},
      {"novanta", "FBK_BISS1_SSI1_FRAMESIZE=3", "did you mean FBK_BISS1_SSI1_FRAME_SIZE?"},
      {"novanta", "FBK_BISS1_SSI1_FRAME_SIZE=39",
       "missing_key: give FBK_BISS1_SSI1_POS_BITS, FBK_BISS1_SSI1_POS_ST_BITS, "
       "FBK_BISS1_SSI1_POS_START_BIT"},
      {"ti-am243x", "", "missing_key: give single_turn_len, multi_turn_len"},
      {"ti-am243x", "baud=1", "missing_key: give single_turn_len, multi_turn_len"},
      {"ax8000-linear", "x=1", "32EF:0E, 32EF:0F"},
      {"el5042", ":11=67", "write 0x67 or, if it is decimal, 0x43"},
      {"el5042", ":11=43", "write 0x43 or, if it is decimal, 0x2B"},
      {"geo-brick", "channel=211492", "write 0x211492 or, if it is decimal, 0x33A24"},
      {"geo-brick", "channel=$211692", "the bits 0x200 have no meaning in this table"},
      {"ic-mb4", "0xC0=0x15B 0xC1=0x06", "the bits 0x100 have no meaning in this table"},
      {"el5042", ":12=60", "Supply Voltage, 0.1 V, of both channels: 50, 90"},
      {"keb-f5", "Ec.01=60 Ec.44=19 Ec.53=12", "59, 72"},
      {"akd2g-rotary", "FB1.MULTITURNBITS=12", "or are not in this table"},
      {"akd2g-rotary", "FB1.BITS=26", "unknown_key: 'FB1.BITS'"},
      {"nxp-biss", "dataLen=28 mtLen=0 stLen=26 crcPoly=0x59", "the usual polynomial"},
      {"ax8000-rotary", "32EF:03=0x20000000 32EF:04=4096", "position: "},
      {"el5042", ":15=12 80p8:15=12", "key_twice: 80p8:15"},
      {"el5042", ":15", "no_value: ':15': write KEY=VALUE"},
      {"el5042", ":15=", "wrong_value: 80p8:15=: Multiturn [Bit]: a number from 0 to 64"},
      {"el5042", ":15=65", "a number from 0 to 64"},
      {"el5042", ":15=-1", "a number from 0 to 64"},
      {"el5042", ":15=1e1", "a number from 0 to 64"},
      {"el5042", ":15=12.0", "a number from 0 to 64"},
      {"el5042", ":15= 12", "a number from 0 to 64"},
      {"el5042", ":15=18446744073709551616", "a number from 0 to 64"},
      {"el5042", ":11=0x100000000", "a number from 0 to 4294967295"},
      {"el5042", ":13=5", "0, 1, 2, 3, 4, 9, 17, 19"},
      {"el5042", ":02=2", "a number from 0 to 1"},
      {"el5042", ":18=1", "Mode: only 0"},
      {"el5042", ":15=64 :16=64", "at most 64 bits"},
      {"el5042", ":15=40 :16=30", "at most 64 bits"},
      {"el5042", ":15=0 :16=0", "not_a_format: "},
      {"el5042", ":11=0x42", "full form"},
      {"el5042", ":11=1", "not_a_format: "},
      {"el5042", ":11=0x80000001", "not_a_format: "},
      {"el5042", ":14=1", "coding: Gray code of multiturn and singleturn bits"},
      {"ax8000-rotary", "32EF:03=1000 32EF:04=1", "a power of 2"},
      {"ax8000-rotary", "32EF:03=0 32EF:04=1", "a power of 2"},
      {"ax8000-rotary", "32EF:0C=67", "unknown_value: 32EF:0C"},
      {"galil", "SSA=1,26,26,0", "wrong_value: SSA=1,26,26,0"},
      {"galil", "SSA=1,26,26", "wrong_value: "},
      {"galil", "SSA=", "wrong_value: "},
      {"galil", "SSA=1,26,26,0<4<5", "wrong_value: "},
      {"galil", "SSA=0,26,26,0<4", "a number from 1 to 2"},
      {"galil", "SSA=1,-39,26,0<4", "a number from 1 to 38"},
      {"galil", "SSA=1,26,-26,0<4", "a number from 0 to 38"},
      {"galil", "SSA=1,19,31,0<4", "not_a_format: "},
      {"geo-brick", "channel=$219492", "type C"},
      {"geo-brick", "channel=$1000000000", "wrong_value: "},
      {"geo-brick", "channel=211492h", "wrong_value: "},
      {"geo-brick", "channel=$211480", "a number from 12 to 40"},
      {"geo-brick", "channel=$001492", "CRC mask: a number from 1 to 255"},
      {"novanta",
       "FBK_BISS1_SSI1_FRAME_SIZE=40 FBK_BISS1_SSI1_POS_BITS=31 FBK_BISS1_SSI1_POS_ST_BITS=19 "
       "FBK_BISS1_SSI1_POS_START_BIT=8",
       "contradiction: for mt12,st19,nE,nW,crc6: FBK_BISS1_SSI1_FRAME_SIZE (position, flags, CRC) "
       "is "
       "40 and must be 39"},
      {"novanta",
       "FBK_BISS1_SSI1_FRAME_SIZE=39 FBK_BISS1_SSI1_POS_BITS=31 FBK_BISS1_SSI1_POS_ST_BITS=19 "
       "FBK_BISS1_SSI1_POS_START_BIT=3",
       "not_a_format: "},
      {"synapticon", "0x2110:09=31 0x2110:10=12 0x2110:12=19 0x2110:13=11", "not_a_format: "},
      {"synapticon", "0x2110:09=30 0x2110:10=12 0x2110:12=19 0x2110:13=12", "contradiction: "},
      {"pandablocks", "BITS=26 CLK_PERIOD=0.0001", "0.001 to 1000 us"},
      {"pandablocks", "BITS=26 CLK_PERIOD=fast", "0.001 to 1000 us"},
      {"pandablocks", "BITS=26 PROTOCOL=SSI", "protocol: BISS"},
      {"moteus", "aux1.bissc.data_bits=26 cpr=18446744073709551615", "a power of 2"},
      {"moteus", "aux1.bissc.data_bits=26 aux1.bissc.crc_bits=5", "CRC bits: only 6"},
      {"nxp-biss", "dataLen=33 mtLen=12 stLen=20 crcPoly=0x43", "contradiction: "},
      {"linuxcnc", "biss_chan_0=crc%6uwarn%1berror%1bpos%e", "wrong_value: "},
      {"linuxcnc", "biss_chan_0=", "wrong_value: "},
      {"linuxcnc", "biss_chan_0=pos", "wrong_value: "},
      {"linuxcnc", "biss_chan_0=pos%", "wrong_value: "},
      {"linuxcnc", "biss_chan_0=%", "wrong_value: "},
      {"linuxcnc", "biss_chan_0=pos%26gm", "wrong_value: "},
      {"linuxcnc", "biss_chan_0=crc%6uwarn%1berror%1bpos%26x", "type; m"},
      {"linuxcnc", "biss_chan_0=crc%6uwarn%1berror%1bpos%26ex", "type; m"},
      {"linuxcnc", "biss_chan_0=crc%6uwarn%1berror%1bpos%99999999999999999999e", "1 to 31"},
      {"linuxcnc", "biss_chan_0=crc%12uwarn%1berror%1bpos%26e",
       "not_a_format: pos26,nE,nW,crc12: "},
  };
  for (const Wrong& each : wrong) {
    SCOPED_TRACE(fmt::format("{} {}", each.master, each.settings));
    auto words = words_of(each.settings);
    if (std::string_view(each.settings) == ":15= 12") words = {each.settings};
    const std::string error = error_of(master_of(each.master), words);
    EXPECT_THAT(error, HasSubstr(each.why));
    EXPECT_THAT(error, testing::StartsWith(std::string(each.master) + ": "));
  }
}

TEST(Settings, SettingsOfAnotherFormat_ContradictIt) {
  const Master& el5042 = master_of("el5042");
  const std::vector<std::string> given{":15=12", ":16=19"};
  EXPECT_EQ(text(format_of(el5042, given, format(f31)).format), f31);
  EXPECT_THAT(error_of(el5042, given, format(f26)),
              HasSubstr("80p8:15 (Multiturn [Bit]) is 12 and must be 0"));
  EXPECT_THAT(
      error_of(el5042, given, format("mt12,st19,nE,nW,crc5")),
      HasSubstr("80p8:11 (CRC Polynomial) is 0x43, the default, as it was left out, and must "
                "be 0x25"));
  EXPECT_THAT(
      error_of(master_of("linuxcnc"), {"biss_chan_0=crc%6uwarn%1berror%1bpos%27e"}, format(f26)),
      HasSubstr("biss_chan_0 (position bits) is 27 and must be 26"));
  EXPECT_THAT(error_of(el5042, given, format("mt12,st20,nE,nW,lc6,crc16")),
              HasSubstr("arrangement"));
}

TEST(Settings, OpenFacts_AreListedAndCloseWithTheFormat) {
  const Found found = format_of(master_of("moteus"), {"aux1.bissc.data_bits=31"}, {});
  EXPECT_EQ(text(found.format), "pos31,nE,nW,crc6");
  EXPECT_THAT(found.open, testing::Contains("turns: pos31, or mtA,stB with A + B = 31"));
  const Found closed = format_of(master_of("moteus"), {"aux1.bissc.data_bits=31"}, format(f31));
  EXPECT_EQ(text(closed.format), f31);
  EXPECT_TRUE(closed.open.empty());
  const Found words =
      format_of(master_of("ic-mb3"), {"SDLEN=27", "INVCRCS=1", "SENSCRCPOLY=0x21"}, {});
  EXPECT_THAT(words.open, testing::Contains(HasSubstr("28 bits before the CRC in any order")));
}

TEST(Settings, ValuesAsOnTheScreen_AreRead) {
  const Found found =
      format_of(master_of("el5042"),
                {"80P8:03=FALSE", ":11=0x43", ":13=17", ":15=0", ":16=0x12", ":02=true"}, {});
  EXPECT_EQ(text(found.format), "pos18,nE,nW,crc6:plain");
  EXPECT_EQ(found.times.clock, kilohertz(500));
  EXPECT_THAT(found.open, testing::Contains(HasSubstr("status: ")));
  EXPECT_THAT(found.assumed, testing::ElementsAre("80p8:01=0", "80p8:12=50", "80p8:14=0",
                                                  "80p8:17=0", "80p8:18=0"));
  EXPECT_EQ(text(format_of(master_of("el5042"), {":11=0", ":15=0", ":16=9"}, {}).format),
            "pos9,nE,nW");
  const Found drive =
      format_of(master_of("synapticon"), {"0x2110:09=26", "0x2110:12=26", "0x2110:16=25"}, {});
  EXPECT_EQ(drive.times.ack_max, microseconds(25));
}

// ---- The command

TEST(Settings, Command_PrintsTableAndObjects) {
  const Ran table = settings({"-f", "resolute-26", "--for", "synapticon", "--ack-max", "25us"});
  EXPECT_EQ(table.status, ExitStatus::done) << table.err;
  EXPECT_THAT(table.out, testing::ContainsRegex("0x2110:16 +25 "));
  EXPECT_THAT(table.out, HasSubstr("\nsource "));
  const Ran object = settings({"-f", f31, "--for", "galil", "--to", "jsonl"});
  const auto json = nlohmann::json::parse(object.out);
  EXPECT_EQ(json["value"], "1,31,19,0<14");
  EXPECT_EQ(json["master"], "galil");
  EXPECT_THAT(json["doubt"].get<std::string>(), HasSubstr("the command SI"));
  const Ran back = settings({"--from", "galil", "SSA=1,31,19,0<14", "--to", "jsonl"});
  EXPECT_EQ(nlohmann::json::parse(back.out)["format"], f31);
  EXPECT_EQ(nlohmann::json::parse(back.out)["clock_hz"], 900'000);
  const Ran all = settings({"-f", "fs-36-28", "--for", "all", "--to", "csv"});
  EXPECT_EQ(std::count(all.out.begin(), all.out.end(), '\n'),
            static_cast<std::ptrdiff_t>(masters().size()) + 1);
}

// The clock and the ACK of a drive with those of an encoder.
TEST(Settings, TimesOfADrive_AreComparedWithTheEncoder) {
  const auto compare = [](std::vector<std::string> more) {
    more.insert(more.begin(), {"--from", "synapticon", "0x2110:09=26", "0x2110:12=26"});
    return settings(more);
  };
  const Ran same = compare({"0x2110:16=25", "-f", "resolute-26", "--ack-max", "25us"});
  EXPECT_THAT(same.out, HasSubstr("clock: not in the settings"));
  EXPECT_THAT(same.out, HasSubstr("timeout"));
  EXPECT_THAT(same.out, testing::Not(HasSubstr("ACK: ")));
  EXPECT_THAT(compare({"0x2110:16=24", "-f", "resolute-26", "--ack-max", "25us"}).err,
              HasSubstr("contradiction: the drive waits 24 us for START"));
  EXPECT_THAT(compare({"-f", "resolute-26"}).out, HasSubstr("ACK: not in the settings"));
  EXPECT_THAT(compare({"0x2110:16=24", "-f", f26}).out, HasSubstr("ACK: not known from -f"));
  EXPECT_THAT(compare({"0x2110:14=40"}).out,
              testing::ContainsRegex("timeout +40 us, of the drive"));
  const auto clock = [](const char* code, std::vector<std::string> more) {
    more.insert(more.begin(), {"--from", "el5042", ":15=0", ":16=26", code, "-f", f26});
    return settings(more);
  };
  EXPECT_THAT(clock(":13=0", {"--clock-max", "5MHz"}).err,
              HasSubstr("el5042: contradiction: the encoder does not accept the clock 10 MHz"));
  EXPECT_THAT(clock(":13=1", {"--clock-max", "5MHz"}).out, testing::Not(HasSubstr("clock: ")));
  EXPECT_THAT(clock(":13=0", {}).out, HasSubstr("clock: -f has only the limits of BiSS C"));
  const auto crc8 =
      format_of(master_of("el5042"), {":15=0", ":16=26", ":11=0x97"}, format("pos26,nE,nW,crc8"));
  const auto rotary = format_of(master_of("akd2g-rotary"), {"FB1.MULTITURNBITS=12"}, format(f31));
  EXPECT_THAT(rotary.not_compared, testing::Contains("singleturn bits"));
  EXPECT_THAT(crc8.not_compared, testing::Contains("80p8:11: CRC Polynomial"));
  EXPECT_THAT(clock(":01=1", {}).out, HasSubstr("80p8:01: Invert feedback direction"));
  for (const std::vector<std::string>& refused : std::vector<std::vector<std::string>>{
           {"--clock", "5MHz"}, {"--timeout", "static:20us"}, {"--ack-max", "5us"}}) {
    EXPECT_THAT(clock(":13=0", refused).err, HasSubstr("is not compared with these settings"));
  }
  // The drive waits at least its default.
  const auto timeout = [](const char* rule) {
    return settings({"-f", f26, "--for", "synapticon", "--timeout", rule}).out;
  };
  EXPECT_THAT(timeout("static:20us"), testing::ContainsRegex("0x2110:14 +36 "));
  EXPECT_THAT(timeout("static:40us"), testing::ContainsRegex("0x2110:14 +40 "));
  EXPECT_THAT(settings({"-f", f26, "--for", "ax8000-linear", "--ack-max", "16us"}).out,
              testing::ContainsRegex("32EF:0C +160 "));
}

TEST(Settings, WrongUsage_IsOneLine) {
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--for", "el5042"},
           {"-f", f26},
           {":15=12"},
           {"-f", f26, "--for", "el5043"},
           {"-f", f26, "--for", "odrive"},
           {"--from", "siemens", "a=1"},
           {"--from", "el5042", "--for", "akd"},
           {"-f", "pos26,nE,nW,crc6:plain", "--for", "akd"},
           {"-f", "resolute-26", "--for", "el5042", "--clock", "20MHz"},
           {"-f", f26, "--for", "el5042", "--clock", "4MHz"},
           {"--from", "el5042"},
           {"--from", "all", "x=1"},
           {"--from", "el5042", "x"}}) {
    SCOPED_TRACE(arguments.back());
    expect_wrong_usage(settings(arguments));
  }
  EXPECT_THAT(settings({"-f", f26, "--for", "el504"}).err, HasSubstr("did you mean el5042?"));
  EXPECT_THAT(settings({"-f", f26, "--for", "odrive"}).err,
              HasSubstr("no_settings: odrive: no support of BiSS C was found"));
}

// ---- The table

TEST(Settings, Table_IsCompleteAndNamesItsDoubts) {
  std::set<std::string_view> names;
  for (const Master& master : masters()) {
    SCOPED_TRACE(master.name);
    EXPECT_TRUE(names.insert(master.name).second);
    EXPECT_FALSE(master.product.empty() || master.place.empty() || master.source.empty());
    EXPECT_FALSE(master.parameters.empty());
    for (const Parameter& row : master.parameters) {
      EXPECT_THAT(
          (std::vector<std::string_view>{"documentation", "program text", "inferred", "not known"}),
          testing::Contains(row.known));
      EXPECT_EQ(row.term == "unknown", row.known == "not known") << row.key;
      EXPECT_TRUE(row.term != "unknown" || !row.doubt.empty()) << row.key;
      EXPECT_LE(row.low, row.high) << row.key;
      EXPECT_LE(row.shift + row.bits, 32U) << row.key;
      EXPECT_TRUE(row.term != "constant" || row.fallback) << row.key;
      if (row.term == "clock") {
        EXPECT_TRUE(row.base != 0 || row.unit != 0 || !row.codes.empty() ||
                    row.form == Form::microseconds)
            << row.key;
      }
    }
  }
}

// The table of masters in docs/settings.md has a row for each.
TEST(Settings, Document_ListsEveryMaster) {
  std::ifstream file(std::string(BISS_SOURCE_FOLDER) + "/docs/settings.md");
  std::stringstream content;
  content << file.rdbuf();
  for (const Master& master : masters()) {
    std::string doubts;
    std::set<std::string_view> seen;
    for (const Parameter& row : master.parameters) {
      const bool uncertain = row.known == "inferred" || row.known == "not known";
      if (uncertain && !row.key.empty() && seen.insert(row.key).second) {
        doubts += fmt::format("{}`{}`", doubts.empty() ? "" : ", ", row.key);
      }
    }
    EXPECT_THAT(content.str(), HasSubstr(fmt::format("| `{}` | {} | {} | {} |\n", master.name,
                                                     master.product, doubts, master.source)));
  }
}

}  // namespace settings_test
}  // namespace biss::verbs
