// The functions that biss.mjs calls. Texts and arrays are in memory of this module until the next
// call.
#include <emscripten.h>

#include <bit>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "biss/frame/status.hpp"
#include "biss/safety/verdict.hpp"
#include "device/words.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/output.hpp"
#include "wasm/command.hpp"
#include "wasm/cycle_json.hpp"
#include "wasm/session.hpp"

namespace {

using biss::wasm::LineView;
using biss::wasm::Session;

std::string text;
LineView view;
std::vector<std::uint64_t> values;
std::vector<std::uint8_t> present;

const char* keep(std::string kept) {
  text = std::move(kept);
  return text.c_str();
}

}  // namespace

extern "C" {

EMSCRIPTEN_KEEPALIVE int biss_run(const char* request) {
  return static_cast<int>(biss::wasm::run_command(request));
}

EMSCRIPTEN_KEEPALIVE const char* biss_verbs() { return keep(biss::wasm::described_verbs()); }

// Statuses and verdicts with their words, in the order of their values.
EMSCRIPTEN_KEEPALIVE const char* biss_words() {
  nlohmann::json words;
  for (std::size_t i = 0; i < biss::cycle_status_count; ++i) {
    const auto status = static_cast<biss::CycleStatus>(i);
    words["statuses"].push_back({{"name", name_of(status)},
                                 {"seen", words_of(status).seen},
                                 {"fault", is_fault(status)},
                                 {"cut", is_cut(status)}});
  }
  for (std::size_t i = 0; i < biss::safety_verdict_count; ++i) {
    const biss::SafetyVerdict verdict = biss::verdict_of(i);
    words["verdicts"].push_back({{"name", name_of(verdict)}, {"fault", is_fault(verdict)}});
  }
  return keep(biss::wasm::dumped(words));
}

// Null if memory has run out. If the capture cannot be opened, the session has only its status.
EMSCRIPTEN_KEEPALIVE Session* biss_open(const char* request, int any_lines) {
  try {
    return new Session(biss::wasm::Request(request), any_lines != 0);
  } catch (const std::bad_alloc&) {
    biss::verbs::ProcessHost().warn("out of memory");
    return nullptr;
  }
}

EMSCRIPTEN_KEEPALIVE void biss_close(Session* session) { delete session; }

EMSCRIPTEN_KEEPALIVE int biss_status(const Session* session) {
  return static_cast<int>(session->status());
}

// 1: more is to be read; 0: the end; -1: memory has run out.
EMSCRIPTEN_KEEPALIVE int biss_advance(Session* session, double milliseconds) {
  try {
    return session->advance(milliseconds) ? 1 : 0;
  } catch (const std::bad_alloc&) {
    biss::verbs::ProcessHost().warn("out of memory");
    return -1;
  }
}

EMSCRIPTEN_KEEPALIVE const char* biss_about(Session* session) { return keep(session->about()); }

EMSCRIPTEN_KEEPALIVE const char* biss_columns(const Session* session) {
  return keep(session->columns_text());
}

EMSCRIPTEN_KEEPALIVE double biss_row_count(const Session* session) {
  return static_cast<double>(session->rows().rows());
}

EMSCRIPTEN_KEEPALIVE const char* biss_rows(const Session* session, double from, double to) {
  return keep(session->rows().text(biss::report::Format::csv, static_cast<std::size_t>(from),
                                   static_cast<std::size_t>(to)));
}

// The values; biss_present() has their presence. Bits are not values.
EMSCRIPTEN_KEEPALIVE const std::uint64_t* biss_column(const Session* session, int index,
                                                      double from, double to) {
  const auto& stored = session->rows().columns()[static_cast<std::size_t>(index)];
  values.clear();
  present.clear();
  for (auto row = static_cast<std::size_t>(from); row < static_cast<std::size_t>(to); ++row) {
    present.push_back(stored.is_absent(row) ? 0 : 1);
    if (stored.column.kind != biss::report::Kind::bits) values.push_back(stored.number(row));
  }
  return values.data();
}

EMSCRIPTEN_KEEPALIVE const std::uint8_t* biss_present() { return present.data(); }

// A text of a text column; null beyond the last one.
EMSCRIPTEN_KEEPALIVE const char* biss_column_text(const Session* session, int index, int number) {
  const auto& texts = session->rows().columns()[static_cast<std::size_t>(index)].texts;
  const auto at = static_cast<std::size_t>(number);
  return at < texts.size() ? texts[at].c_str() : nullptr;
}

// How many entries the view has; biss_view_times() and biss_view_levels() have them.
EMSCRIPTEN_KEEPALIVE int biss_view(const Session* session, int ma, std::int64_t from,
                                   std::int64_t to, int columns) {
  session->line(ma != 0).view(biss::picoseconds(from), biss::picoseconds(to),
                              static_cast<std::uint32_t>(columns), view);
  return static_cast<int>(view.times.size());
}

EMSCRIPTEN_KEEPALIVE const std::int64_t* biss_view_times() { return view.times.data(); }
EMSCRIPTEN_KEEPALIVE const std::uint8_t* biss_view_levels() { return view.shown.data(); }

EMSCRIPTEN_KEEPALIVE const char* biss_summary(const Session* session) {
  return keep(session->summary());
}

// Null if the edges do not show the cycle. A negative number stands for the number of the row.
EMSCRIPTEN_KEEPALIVE const char* biss_cycle(Session* session, double row, double number) {
  auto cycle =
      session->cycle(static_cast<std::uint64_t>(row),
                     number < 0 ? std::nullopt : std::optional(static_cast<std::uint64_t>(number)));
  return cycle ? keep(std::move(*cycle)) : nullptr;
}

EMSCRIPTEN_KEEPALIVE const char* biss_accesses(const Session* session, double first, double end) {
  return keep(
      session->accesses(static_cast<std::uint64_t>(first), static_cast<std::uint64_t>(end)));
}

}  // extern "C"
