#include "wasm/session.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <new>
#include <nlohmann/json.hpp>
#include <vector>

#include "biss/frame/format_text.hpp"
#include "report/sink.hpp"
#include "verbs/common/host.hpp"
#include "verbs/registers/access_rows.hpp"
#include "wasm/cycle_json.hpp"

namespace biss::wasm {
namespace {

using nlohmann::json;
using wire::Level;

// In the order of decode::LineOrigin.
constexpr std::array<std::string_view, 3> origin_names{"given", "name", "behaviour"};

std::string_view line_kind(const verbs::CaptureInput& input) {
  if (input.is_analog()) return "voltages";
  return input.sample_period() == Picoseconds{} ? "changes" : "samples";
}

// The edges of both lines in time order, of each line only the first ones if there are many.
std::vector<wire::Edge> edges_between(const LineStore& ma, const LineStore& slo,
                                      const decode::Lines& lines, Picoseconds from,
                                      Picoseconds to) {
  std::vector<wire::Edge> edges;
  const auto add = [&](const LineStore& store, wire::LineIndex line) {
    constexpr std::size_t most = 32'768;
    const std::size_t begin = edges.size();
    const Level before = store.level_at(from - picoseconds(1));
    if (before != Level::unknown) edges.push_back({from, line, before});
    store.for_each(from, [&](Picoseconds time, Level level) {
      if (time > to || edges.size() - begin == most) return false;
      edges.push_back({time, line, level});
      return true;
    });
  };
  add(ma, lines.ma);
  add(slo, lines.slo);
  std::stable_sort(edges.begin(), edges.end(),
                   [](const wire::Edge& a, const wire::Edge& b) { return a.time < b.time; });
  return edges;
}

}  // namespace

Session::Session(const Request& request, bool any_lines)
    : listener_([this](const decode::SeenAccess& access) {
        const bool command = access.kind == decode::SeenAccess::Kind::command;
        const int slaves = command ? std::popcount(access.slaves) : 1;
        access_rows_ += static_cast<std::size_t>(std::max(slaves, 1));
        accesses_.push_back(access);
      }) {
  verbs::Command command(host_);
  const verbs::Verb verb = command.add_verb(verbs::decode_text(), [&](verbs::Host& /*host*/) {
    options_.capture.any_lines = any_lines;
    return begin();
  });
  verbs::add_decode_options(verb, options_);
  status_ = command.run(request.words, request.options);
}

Session::~Session() = default;

verbs::ExitStatus Session::begin() {
  run_ = std::make_unique<verbs::DecodeRun>(options_, host_);
  verbs::ExitStatus status = run_->open();
  if (status != verbs::ExitStatus::done) return status;
  if (run_->capture().several()) {
    return host_.fail(
        verbs::ExitStatus::usage,
        "a page reads one capture and one pair of lines; name them with --ma and --slo");
  }
  status = run_->next();
  if (status != verbs::ExitStatus::done) return status;
  rows_.emplace(run_->columns());
  status = run_->begin_rows();
  if (status != verbs::ExitStatus::done) return status;
  const auto take = [this](std::uint64_t number, const decode::Cycle& cycle) {
    listener_.push(number, cycle);
    return run_->take(number, cycle, *rows_);
  };
  run_->capture().begin_steps(take, this);
  return verbs::ExitStatus::done;
}

bool Session::advance(double milliseconds) {
  using Clock = std::chrono::steady_clock;
  const auto until = Clock::now() + std::chrono::duration<double, std::milli>(milliseconds);
  while (!ended_) {
    if (!run_->capture().step()) end();
    if (Clock::now() >= until) break;
  }
  return !ended_;
}

void Session::end() {
  ended_ = true;
  verbs::RunMessages messages;
  const bool read = run_->capture().end_steps();
  listener_.finish();
  status_ = run_->end_rows(read, messages);
  messages.print(host_);
}

void Session::take(std::span<const wire::Edge> edges) {
  const decode::Lines& lines = run_->capture().lines().lines;
  for (const wire::Edge& edge : edges) {
    if (edge.line == lines.ma) ma_.push(edge.time, edge.level);
    if (edge.line == lines.slo) slo_.push(edge.time, edge.level);
  }
}

void Session::take(const capture::PairPiece& changes) {
  const auto add = [](LineStore& store, const capture::LineChanges& line) {
    bool high = line.first_high;
    for (const std::int64_t time : line.times) {
      store.push(picoseconds(time), high ? Level::high : Level::low);
      high = !high;
    }
  };
  add(ma_, changes.ma);
  add(slo_, changes.slo);
}

std::string Session::about() {
  verbs::DecodedCapture& capture = run_->capture();
  const decode::FoundLines& found = capture.lines();
  json about{{"name", capture.input().name()},
             {"lines", capture.input().lines()},
             {"ma", capture.ma_name()},
             {"slo", capture.slo_name()},
             {"maInverted", found.lines.ma_inverted},
             {"sloInverted", found.lines.slo_inverted},
             {"linesBy", origin_names[static_cast<std::size_t>(found.origin)]},
             {"looksSwapped", found.look_swapped},
             {"furtherPairs", found.further_pairs},
             {"samplePeriod", exact(capture.input().sample_period())},
             {"sampleRate", capture.input().sample_rate().count},
             {"endTime", exact(capture.input().end_time())},
             {"lineKind", line_kind(capture.input())},
             {"cycles", rows_->rows()},
             {"accesses", access_rows_},
             {"ended", ended_},
             {"status", static_cast<int>(status_)},
             {"error", capture.input().error()}};
  if (capture.format()) about["format"] = format_text(*capture.format()).view();
  const std::string& given = options_.capture.device.format;
  const auto device = biss::parse_device(given.empty() ? "none" : given);
  const bool named = device && (device->entry != nullptr || device->configuration != nullptr);
  if (named) about["formatName"] = given;
  const auto* finding = capture.finding();
  const auto* sure = finding != nullptr ? finding->sure() : nullptr;
  if (sure != nullptr) {
    about["confidence"] = sure->confidence;
    about["encoders"] = sure->encoders;
  }
  return dumped(about);
}

std::string Session::columns_text() const {
  json columns = json::array();
  for (const auto& stored : rows_->columns()) {
    const report::Column& column = stored.column;
    columns.push_back({{"name", column.name},
                       {"kind", report::kind_names[static_cast<std::size_t>(column.kind)]},
                       {"heading", column.heading.empty() ? column.name : column.heading},
                       {"unit", column.unit},
                       {"valueUnit", column.value_unit},
                       {"shift", column.shift},
                       {"role", report::role_names[static_cast<std::size_t>(column.role)]},
                       {"title", column.title},
                       {"plot", column.plot}});
  }
  return dumped(columns);
}

Picoseconds Session::time_of(std::uint64_t row) const {
  const std::uint64_t time = rows_->column("time_ns").number(static_cast<std::size_t>(row));
  return picoseconds(static_cast<std::int64_t>(time));
}

std::optional<std::string> Session::cycle(std::uint64_t row, std::optional<std::uint64_t> number) {
  // Cycles around it show the clock.
  constexpr std::uint64_t around = 2;
  const std::uint64_t last = rows_->rows() - 1;
  const Picoseconds time = time_of(row);
  const Picoseconds before = time_of(row - std::min(row, around));
  const bool to_end = last - row <= around;
  verbs::DecodedCapture& capture = run_->capture();
  const Picoseconds end = capture.input().end_time();
  const Picoseconds wanted = row <= around ? before - milliseconds(1) : before - picoseconds(1);
  const Picoseconds from = std::max({wanted, ma_.some_before(time), slo_.some_before(time)});
  const Picoseconds to = to_end ? end : time_of(row + around + 1);
  if (!number) number = rows_->column("cycle").number(static_cast<std::size_t>(row));
  std::optional<json> found;
  decode::CycleEdgeReader cycles(
      capture.reader(), capture.lines().lines, [&](const decode::CycleEdges& edges) {
        if (edges.cycle.time != time) return;
        found = cycle_json(*number, edges, capture.format(), capture.timing(), capture.margin());
      });
  cycles.push(edges_between(ma_, slo_, capture.lines().lines, from, to));
  if (!found) cycles.finish(to);
  if (!found) return std::nullopt;
  return dumped(*found);
}

std::string Session::accesses(std::uint64_t first, std::uint64_t end) const {
  // In the order of cycles, and one after the other.
  const auto from_cycle = [&](std::uint64_t wanted) {
    return std::partition_point(
        accesses_.begin(), accesses_.end(),
        [wanted](const decode::SeenAccess& access) { return access.cycle < wanted; });
  };
  auto access = from_cycle(first);
  while (access != accesses_.begin() && access[-1].cycle + access[-1].cycles > first) --access;
  report::StringSink text;
  const auto writer =
      report::make_table_writer(report::Format::jsonl, verbs::access_columns(), text);
  for (; access != accesses_.end() && access->cycle < end; ++access) {
    verbs::write_access(*writer, *access);
  }
  writer->finish();
  return text.text();
}

}  // namespace biss::wasm
