#include "python/stream.hpp"

#include <algorithm>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "device/quantity.hpp"
#include "draw/cycle_drawing.hpp"
#include "python/verbs.hpp"
#include "report/text.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"

namespace biss::python {
namespace {

// The name of the capture in messages.
constexpr const char* capture_name = "edges";

std::string drawn_time(Picoseconds time) { return biss::text_of(time, 3); }

StreamValue value_of(const report::Cell& cell) {
  using report::Kind;
  switch (cell.kind()) {
    case Kind::unsigned_integer:
    case Kind::flag:
      return cell.unsigned_value();
    case Kind::signed_integer:
      return cell.signed_value();
    case Kind::nanoseconds:
      return cell.time();
    case Kind::real:
      return cell.real_value();
    case Kind::text:
      return std::string(cell.text());
    case Kind::bits: {
      std::string text;
      report::append_hex(text, cell.bits());
      return text;
    }
    case Kind::absent:
      break;
  }
  return {};
}

// Fields of all tracks in the order of time.
std::vector<StreamField> fields_of(const decode::CycleEdges& edges,
                                   const verbs::DecodedCapture& capture) {
  const draw::CycleDrawing drawing = draw::draw_cycle(edges, capture.format(), capture.timing(),
                                                      capture.margin(), draw::DrawnExtent::cycle);
  std::vector<StreamField> fields;
  for (draw::Track& track : draw::tracks_of(drawing, capture.format(), drawn_time)) {
    for (draw::Part& part : track.parts) {
      if (part.from < part.to) fields.push_back({std::move(part), track.name});
    }
  }
  std::stable_sort(fields.begin(), fields.end(), [](const StreamField& a, const StreamField& b) {
    return a.part.from < b.part.from;
  });
  return fields;
}

}  // namespace

// Takes the cells of a row that `biss decode` writes.
class Stream::Rows final : public report::TableWriter {
 public:
  bool row(std::span<const report::Cell> cells) override {
    values.clear();
    for (const report::Cell& cell : cells) values.push_back(value_of(cell));
    written = true;
    return true;
  }
  bool finish() override { return true; }

  std::vector<StreamValue> values;
  bool written = false;
};

Stream::Stream(const verbs::GivenOptions& options, const StreamSetup& setup)
    : setup_(setup), writer_(std::make_unique<Rows>()) {
  queue_.set_period(setup.sample_period);
  host_.give(capture_name,
             {[this](const auto&) -> capture::Opened { return queue_.source(); }, false});
  verbs::Command command(host_);
  const verbs::Verb verb = command.add_verb(verbs::decode_text(), [&](verbs::Host& host) {
    if (options_.to != report::Format::table || !options_.output.empty() ||
        !options_.columns.empty() || !options_.fail_on.empty()) {
      return host.fail(verbs::ExitStatus::usage,
                       "output, to, columns and fail_on are not for rows in memory");
    }
    if (options_.capture.files.size() != 1 || options_.capture.each) {
      return host.fail(verbs::ExitStatus::usage, "a decoder reads one pair of lines, and no file");
    }
    return verbs::ExitStatus::done;
  });
  verbs::add_decode_options(verb, options_);
  auto status = command.run({"decode", capture_name}, options);
  options_.capture.beginning = setup_.beginning;
  run_.emplace(options_, host_);
  if (status == verbs::ExitStatus::done) status = run_->open();
  if (status != verbs::ExitStatus::done) fail(status);
}

Stream::~Stream() = default;

void Stream::fail(verbs::ExitStatus status) {
  failure_ = {status, messages().empty() ? "" : messages().back()};
  status_ = status;
}

verbs::ExitStatus Stream::open() {
  verbs::ExitStatus status = run_->next();
  if (status != verbs::ExitStatus::done) return status;
  columns_ = run_->columns();
  status = run_->begin_rows();
  if (status != verbs::ExitStatus::done) return status;
  verbs::DecodedCapture& capture = run_->capture();
  if (const auto& format = capture.format()) format_ = format_text(*format).view();
  if (setup_.fields) {
    edges_.emplace(capture.reader(), capture.lines().lines,
                   [this, &capture](const decode::CycleEdges& edges) {
                     const std::size_t before = rows_.size();
                     put_row(edges.number, edges.cycle);
                     if (rows_.size() != before) rows_.back().fields = fields_of(edges, capture);
                   });
  } else {
    capture.begin_steps([this](std::uint64_t number, const decode::Cycle& cycle) {
      put_row(number, cycle);
      return true;
    });
  }
  return verbs::ExitStatus::done;
}

void Stream::begin() {
  begun_ = true;
  const verbs::ExitStatus status = open();
  if (status != verbs::ExitStatus::done) fail(status);
}

void Stream::put_row(std::uint64_t number, const decode::Cycle& cycle) {
  writer_->written = false;
  run_->take(number, cycle, *writer_);
  if (!writer_->written) return;
  rows_.push_back({.begin = cycle.time,
                   .end = cycle.time + cycle.clocked,
                   .values = std::move(writer_->values),
                   .fields = {}});
}

bool Stream::waits() const {
  return failure_ || ended_ || queue_.size() < (begun_ ? few_edges : setup_.beginning);
}

void Stream::decode(bool few) {
  if (waits() && !(few && begun_ && !failure_ && !ended_)) return;
  if (!begun_) begin();
  read();
}

void Stream::read() {
  if (failure_) return;
  verbs::DecodedCapture& capture = run_->capture();
  if (edges_) {
    for (auto block = capture.input().next(); !block.empty(); block = capture.input().next()) {
      edges_->push(block);
    }
    return;
  }
  while (capture.step()) {
  }
}

void Stream::finish(Picoseconds end) {
  if (ended_) return;
  queue_.set_end(end);
  if (!failure_ && !begun_) begin();
  read();
  ended_ = true;
  if (!failure_) this->end();
}

void Stream::end() {
  verbs::RunMessages closing;
  verbs::DecodedCapture& capture = run_->capture();
  if (edges_) edges_->finish(capture.input().end_time());
  const bool read = edges_ ? capture.input().error().empty() : capture.end_steps();
  status_ = run_->end_rows(read, closing);
  closing.print(host_);
}

std::vector<StreamRow> Stream::take_rows() { return std::exchange(rows_, {}); }

}  // namespace biss::python
