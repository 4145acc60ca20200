// A feature of the protocol as a file: the lines to the slaves, and their expected answers.
//
//   feature  its heading
//   text     a line of explanation; any number of them
//   slave    pos BITS crc 3|6 position N [sampling T] [start T] [ready T] [ack CLOCKS] [busy
//   CLOCKS]
//            timeout adaptive|fixed|cycle T [static T]; a line a slave, slave 0 first
//   ma       TIMES of all edges, the first one falling
//   slo K    TIMES of all edges of slave K, the first one falling
//   sample K TIMES at which slave K takes its position; may be left out
//   cdm K    TIME BIT …, when slave K reads CDM; may be left out
//   mark     TIME NAME, for the picture
//   draw     FROM TO STEP …, the pieces of time that the picture shows, STEP a character
//
// Times are in ns: 1500, or +500 after the previous edge, or +500*3 for three of these.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "tests/timing/scenario.hpp"

namespace timing_test {

struct Mark {
  oracle::Time time = 0;
  std::string name;
};

struct Piece {
  oracle::Time from = 0;
  oracle::Time to = 0;
  oracle::Time step = 0;
};

struct Feature {
  std::string file;
  std::string heading;
  std::string text;
  Scenario scenario;
  std::map<std::size_t, oracle::Line> slo;
  std::map<std::size_t, std::vector<oracle::Time>> samples;
  std::map<std::size_t, std::vector<oracle::Change>> cdm;
  std::vector<Mark> marks;
  std::vector<Piece> pieces;
};

/// All files of a folder in the order of their names. Throws std::runtime_error with file and line.
std::vector<Feature> read_features(const std::string& folder);

/// The page with all features: headings, text, and each picture as a block of text.
std::string document_of(const std::vector<Feature>& features);

}  // namespace timing_test
