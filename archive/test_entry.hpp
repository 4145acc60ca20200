// For tests: entries with random figures.
#pragma once

#include <random>
#include <string>
#include <utility>

#include "archive/entry.hpp"

namespace biss::archive {

using Random = std::mt19937_64;

inline LinkEntry random_link(Random& random) {
  LinkEntry link;
  link.ma = random() % 2 == 0 ? "MA" : "MA \"1\"\n";
  link.slo = "SLO";
  if (random() % 3 != 0) link.format = "pos26,nE,nW,crc6";
  if (random() % 3 == 0) link.encoders = {"resolute-26", "jtw-26"};
  if (random() % 5 == 0) link.other_format = "pos24,nE,nW,crc6";
  for (std::uint64_t& count : link.counts.by_status) {
    count = random() % 3 == 0 ? random() % 100 : 0;
    link.counts.cycles += count;
  }
  if (link.counts.cycles != 0) {
    link.counts.errors = random() % link.counts.cycles;
    link.counts.warnings = random() % link.counts.cycles;
    link.counts.margin_judged = random() % link.counts.cycles;
    link.counts.limited = random() % link.counts.cycles;
    link.counts.by_limit[random() % link.counts.by_limit.size()] = link.counts.limited;
    if (link.counts.margin_judged != 0) {
      link.counts.marginal = random() % link.counts.margin_judged;
    }
  }
  for (std::size_t i = 0; i < quantity_count; ++i) {
    decode::Distribution values;
    for (std::uint64_t n = random() % 20; n > 0; --n) {
      values.add(static_cast<std::int64_t>(random() >> (random() % 60 + 1)));
    }
    link.histograms.emplace_back(values);
    if (values.count() != 0) link.ranges[i] = {values.min(), values.median(), values.max()};
  }
  return link;
}

inline FileEntry random_entry(Random& random, std::string path) {
  FileEntry entry;
  entry.path = std::move(path);
  entry.bytes = random() >> (random() % 60);
  entry.day = static_cast<Day>(random() % 20'000);
  entry.dated_by_path = random() % 2 == 0;
  entry.reading = static_cast<Reading>(random() % 3);
  if (entry.reading != Reading::whole) {
    entry.cause = random() % 2 == 0 ? "truncated" : "unknown_format";
    entry.message = entry.path + ": the file \xE2\x80\xA6 ends\tearly";
  }
  if (entry.reading != Reading::none) {
    for (std::uint64_t n = random() % 3 + 1; n > 0; --n) entry.links.push_back(random_link(random));
  } else if (random() % 2 == 0) {
    entry.day.reset();
  }
  return entry;
}

}  // namespace biss::archive
