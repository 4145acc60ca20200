// Columns that several verbs show in the same way.
#pragma once

#include "report/table.hpp"

namespace biss::rows {

inline report::Column line_delay_column() {
  return {.name = "line_delay_ns",
          .kind = report::Kind::nanoseconds,
          .heading = "delay",
          .unit = "ns",
          .places = 1,
          .title = "Line delay",
          .plot = 4};
}

inline report::Column ack_column() {
  return {.name = "ack_ns",
          .kind = report::Kind::nanoseconds,
          .heading = "ACK",
          .unit = "ns",
          .places = 0,
          .title = "ACK",
          .plot = 5};
}

inline report::Column clock_column() {
  return {.name = "clock_hz",
          .kind = report::Kind::unsigned_integer,
          .heading = "clock",
          .unit = "MHz",
          .bits = 32,
          .value_unit = "Hz",
          .shift = 6,
          .places = 3,
          .title = "Clock",
          .plot = 6};
}

}  // namespace biss::rows
