// The decoder in Python that is fed piece by piece.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>
#include <mutex>
#include <optional>
#include <utility>

#include "biss/frame/format_text.hpp"
#include "capture/samples.hpp"
#include "decode/cycle_edges.hpp"
#include "device/quantity.hpp"
#include "draw/cycle_drawing.hpp"
#include "draw/layout.hpp"
#include "python/arrays.hpp"
#include "python/module.hpp"
#include "python/numpy_arrays.hpp"
#include "report/row_store.hpp"
#include "verbs/common/host.hpp"
#include "verbs/common/verb.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::python {
namespace {

constexpr std::int64_t no_time = std::numeric_limits<std::int64_t>::min();
constexpr std::size_t few_edges = 512;

// The rows of `biss decode`, until Python takes them.
template <class T>
using Vector = std::vector<T>;
using Rows = report::RowStore<Vector>;

// A stretch of the line, and the name of its track.
struct StreamField {
  draw::Part part;
  std::string track;
};

// The place of a row in time.
struct StreamRow {
  // The first edge of MA and the last one.
  Picoseconds begin{};
  Picoseconds end{};
  // In the order of time; of all tracks.
  std::vector<StreamField> fields{};
};

// The name of the capture in messages.
constexpr const char* capture_name = "edges";

std::string drawn_time(Picoseconds time) { return biss::text_of(time, 3); }

// Bits are a text as the command writes them.
py::object object_of(const Rows::Stored& stored, std::size_t row) {
  using report::Kind;
  if (stored.is_absent(row)) return py::none();
  const Kind kind = stored.column.kind;
  if (kind == Kind::bits) {
    std::string digits;
    for (std::size_t lane = 0; lane < stored.lanes; ++lane) {
      digits += fmt::format("{:016X}", stored.numbers[row * stored.lanes + lane]);
    }
    const std::size_t count = (stored.bit_counts[row] + 3U) / 4;
    return py::str(count == 0 ? "" : "0x" + digits.substr(digits.size() - count));
  }
  const std::uint64_t number = stored.number(row);
  const auto with_sign = static_cast<std::int64_t>(number);
  if (kind == Kind::text) return text_object(stored.texts[number]);
  if (kind == Kind::signed_integer) return py::int_(with_sign);
  if (kind == Kind::nanoseconds) return py::float_(static_cast<double>(with_sign) / 1000.0);
  if (kind == Kind::real) return py::float_(std::bit_cast<double>(number));
  return py::int_(number);
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

py::object optional_of(const std::optional<std::uint64_t>& value) {
  if (!value) return py::none();
  return py::int_(*value);
}

py::tuple tuple_of(const StreamField& field) {
  const draw::Part& part = field.part;
  return py::make_tuple(part.from.count, part.to.count, part.name, optional_of(part.value),
                        optional_of(part.expected), part.wrong, part.text,
                        part.brief.empty() ? part.text : part.brief, field.track);
}

// `biss decode` on edges that are pushed. If the format is given, the rows are the same as from the
// command on the same capture; else the format is found in the beginning alone. One thread at a time
// is in it; see in_turn().
class StreamObject {
 public:
  // Held by the call that uses the decoder.
  std::mutex mutex;

  StreamObject(const verbs::GivenOptions& options, std::uint32_t sample_rate, bool fields,
               std::size_t beginning)
      : fields_(fields), beginning_(beginning) {
    if (sample_rate != 0) {
      clock_.emplace(hertz(sample_rate));
      queue_.set_period(capture::longest_period(hertz(sample_rate)));
    }
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
        return host.fail(verbs::ExitStatus::usage,
                         "a decoder reads one pair of lines, and no file");
      }
      return verbs::ExitStatus::done;
    });
    verbs::add_decode_options(verb, options_);
    auto status = command.run({"decode", capture_name}, options);
    options_.capture.beginning = beginning;
    run_.emplace(options_, host_);
    if (status == verbs::ExitStatus::done) status = run_->open();
    fail_unless_done(status);
  }
  StreamObject(const StreamObject&) = delete;

  py::list edges(const py::array& times_array, const py::array& ma_array,
                 const py::array& slo_array) {
    const auto times = elements_of<std::int64_t>(times_array, "times");
    const auto [ma, slo] = levels(ma_array, slo_array, times.size());
    check_open();
    return take_edges(times, ma, slo);
  }

  py::list changes(const py::array& numbers_array, const py::array& ma_array,
                   const py::array& slo_array) {
    const auto numbers = elements_of<std::int64_t>(numbers_array, "numbers");
    const auto [ma, slo] = levels(ma_array, slo_array, numbers.size());
    check_clock();
    auto last = static_cast<std::int64_t>(next_sample_) - 1;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] < last || numbers[i] < 0) throw UsageError(backwards(i));
      last = numbers[i];
    }
    check_sample(last);
    std::vector<std::int64_t> times;
    times.reserve(numbers.size());
    for (const std::int64_t number : numbers) {
      times.push_back(clock_->time_of(static_cast<std::uint64_t>(number)).count);
    }
    return take_edges(times, ma, slo, static_cast<std::uint64_t>(last + 1));
  }

  py::list samples(const py::array& array, unsigned ma_bit, unsigned slo_bit) {
    check_clock();
    if (py::isinstance<py::array_t<std::uint16_t>>(array)) {
      return take_samples(elements_of<std::uint16_t>(array, "samples"), ma_bit, slo_bit);
    }
    if (py::isinstance<py::array_t<std::uint32_t>>(array)) {
      return take_samples(elements_of<std::uint32_t>(array, "samples"), ma_bit, slo_bit);
    }
    if (py::isinstance<py::array_t<std::uint64_t>>(array)) {
      return take_samples(elements_of<std::uint64_t>(array, "samples"), ma_bit, slo_bit);
    }
    return take_samples(elements_of<std::uint8_t>(array, "samples"), ma_bit, slo_bit);
  }

  // Few edges wait for more, except here.
  py::list rows() { return decoded(0); }

  // The capture ends at this time, or at its last edge if that is later.
  py::list finish(std::optional<std::int64_t> end, std::optional<std::uint64_t> end_sample) {
    if (end_sample) {
      if (!clock_) throw UsageError("end_sample: the decoder has no sample_rate");
      if (*end_sample > clock_->last_index()) throw UsageError("end_sample: beyond 106 days");
      end = clock_->time_of(*end_sample).count;
    }
    if (ended_) return py::list();
    const std::int64_t time = std::max(end.value_or(no_time), last_time_);
    queue_.set_end(picoseconds(time == no_time ? 0 : time));
    {
      const py::gil_scoped_release released;
      read();
      ended_ = true;
      if (!failure_) close();
    }
    return take();
  }

  // Why nothing can be read: wrong usage, or the capture has no data that can be decoded.
  py::object failure() {
    if (!failure_) return py::none();
    return py::make_tuple(static_cast<int>(failure_->status), failure_->text);
  }
  // Empty before the beginning has been read.
  py::list columns() {
    py::list columns;
    for (const report::Column& column : columns_) {
      const bool time = column.kind == report::Kind::nanoseconds;
      columns.append(py::make_tuple(column.name, time ? "ns" : column.value_unit));
    }
    return columns;
  }
  // Empty if it is not known.
  std::string format() { return format_; }
  std::string summary() { return host_.summary(); }
  std::vector<std::string> messages() { return host_.lines(); }
  int status() { return static_cast<int>(status_); }

 private:
  void fail_unless_done(verbs::ExitStatus status) {
    if (status == verbs::ExitStatus::done) return;
    failure_ = {status, host_.lines().empty() ? "" : host_.lines().back()};
    status_ = status;
  }

  verbs::ExitStatus open() {
    verbs::ExitStatus status = run_->next();
    if (status != verbs::ExitStatus::done) return status;
    columns_ = run_->columns();
    kept_.emplace(columns_);
    status = run_->begin_rows();
    if (status != verbs::ExitStatus::done) return status;
    verbs::DecodedCapture& capture = run_->capture();
    if (const auto& format = capture.format()) format_ = format_text(*format).view();
    if (fields_) {
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

  void put_row(std::uint64_t number, const decode::Cycle& cycle) {
    const std::size_t before = kept_->rows();
    run_->take(number, cycle, *kept_);
    if (kept_->rows() == before) return;
    rows_.push_back({.begin = cycle.time, .end = cycle.time + cycle.clocked});
  }

  // Decodes the edges that were pushed.
  void read() {
    if (!failure_ && !std::exchange(begun_, true)) fail_unless_done(open());
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

  void close() {
    verbs::RunMessages closing;
    verbs::DecodedCapture& capture = run_->capture();
    if (edges_) edges_->finish(capture.input().end_time());
    const bool read = edges_ ? capture.input().error().empty() : capture.end_steps();
    status_ = run_->end_rows(read, closing);
    closing.print(host_);
  }

  static std::string backwards(std::size_t element) {
    return fmt::format("element {}: time runs backwards", element);
  }

  static std::pair<std::span<const std::uint8_t>, std::span<const std::uint8_t>> levels(
      const py::array& ma_array, const py::array& slo_array, std::size_t size) {
    const auto ma = levels_of(ma_array, "ma");
    const auto slo = levels_of(slo_array, "slo");
    if (ma.size() != size || slo.size() != size) {
      throw UsageError(
          fmt::format("{} times, but {} levels of MA and {} of SLO", size, ma.size(), slo.size()));
    }
    return {ma, slo};
  }

  void check_open() const {
    if (ended_) throw UsageError("the decoder is finished");
  }
  void check_clock() const {
    check_open();
    if (!clock_) throw UsageError("the decoder has no sample_rate");
  }
  void check_sample(std::int64_t number) const {
    if (number >= 0 && static_cast<std::uint64_t>(number) > clock_->last_index()) {
      throw UsageError("a sample beyond 106 days");
    }
  }

  py::list take_edges(std::span<const std::int64_t> times, std::span<const std::uint8_t> ma,
                      std::span<const std::uint8_t> slo,
                      std::optional<std::uint64_t> next_sample = {}) {
    std::int64_t last = last_time_;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] < last) throw UsageError(backwards(i));
      last = times[i];
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
      push(picoseconds(times[i]), ma[i] != 0, slo[i] != 0);
    }
    if (next_sample) next_sample_ = *next_sample;
    return decoded();
  }

  void push(Picoseconds time, bool ma, bool slo) {
    queue_.push(time, ma, slo);
    last_time_ = time.count;
    last_levels_ = static_cast<std::uint8_t>((ma ? 1U : 0U) | (slo ? 2U : 0U));
  }

  template <class T>
  py::list take_samples(std::span<const T> samples, unsigned ma_bit, unsigned slo_bit) {
    if (ma_bit >= 8 * sizeof(T) || slo_bit >= 8 * sizeof(T) || ma_bit == slo_bit) {
      throw UsageError(fmt::format("ma={} and slo={} are not two bits of a sample of {} bits",
                                   ma_bit, slo_bit, 8 * sizeof(T)));
    }
    if (samples.empty()) return decoded();
    check_sample(static_cast<std::int64_t>(next_sample_ + samples.size() - 1));
    if (clock_->time_of(next_sample_).count < last_time_) throw UsageError(backwards(0));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto sample = static_cast<std::uint64_t>(samples[i]);
      const auto both =
          static_cast<std::uint8_t>((sample >> ma_bit & 1U) | (sample >> slo_bit & 1U) << 1U);
      if (both == last_levels_) continue;
      push(clock_->time_of(next_sample_ + i), (both & 1U) != 0, (both & 2U) != 0);
    }
    next_sample_ += samples.size();
    last_time_ = clock_->time_of(next_sample_ - 1).count;
    return decoded();
  }

  // Decodes the edges that were pushed, unless they may belong to the beginning, or are fewer.
  py::list decoded(std::size_t fewer = few_edges) {
    if (failure_ || ended_ || queue_.size() < (begun_ ? fewer : beginning_)) return py::list();
    {
      const py::gil_scoped_release released;
      read();
    }
    return take();
  }

  py::list take() {
    if (rows_.empty()) return py::list();
    // First, so that rows are lost together if memory ends.
    const auto places = std::exchange(rows_, {});
    const std::vector<Rows::Stored> columns = kept_->take_columns();
    kept_.emplace(columns_);
    py::list rows;
    for (std::size_t i = 0; i < places.size(); ++i) {
      py::tuple values(columns.size());
      for (std::size_t k = 0; k < columns.size(); ++k) values[k] = object_of(columns[k], i);
      py::list fields;
      for (const StreamField& field : places[i].fields) fields.append(tuple_of(field));
      rows.append(py::make_tuple(values, places[i].begin.count, places[i].end.count, fields));
    }
    return rows;
  }

  // Rows have fields.
  bool fields_;
  // As InputArguments::beginning.
  std::size_t beginning_;
  verbs::MemoryHost host_;
  verbs::DecodeOptions options_;
  EdgeQueue queue_;
  std::optional<verbs::DecodeRun> run_;
  // With fields: reads the cycles in place of the capture's own decoder.
  std::optional<decode::CycleEdgeReader> edges_;
  std::optional<Rows> kept_;
  std::vector<report::Column> columns_;
  // For each row in `kept_`.
  std::vector<StreamRow> rows_;
  bool begun_ = false;
  bool ended_ = false;
  std::optional<verbs::VerbError> failure_;
  std::string format_;
  verbs::ExitStatus status_ = verbs::ExitStatus::done;
  std::optional<capture::SampleClock> clock_;
  std::uint64_t next_sample_ = 0;
  std::uint8_t last_levels_ = 0xFF;
  std::int64_t last_time_ = no_time;
};

// Calls the method of a StreamObject when the calls of other threads have ended. Other threads of
// Python run while it waits.
template <class Result, class... Arguments>
auto in_turn(Result (StreamObject::*method)(Arguments...)) {
  return [method](StreamObject& stream, Arguments... arguments) {
    std::unique_lock<std::mutex> turn(stream.mutex, std::try_to_lock);
    if (!turn.owns_lock()) {
      const py::gil_scoped_release released;
      turn.lock();
    }
    return (stream.*method)(arguments...);
  };
}

}  // namespace

void add_stream(py::module_& module) {
  py::class_<StreamObject>(module, "Stream")
      .def(py::init<const verbs::GivenOptions&, std::uint32_t, bool, std::size_t>())
      .def("edges", in_turn(&StreamObject::edges))
      .def("changes", in_turn(&StreamObject::changes))
      .def("samples", in_turn(&StreamObject::samples))
      .def("rows", in_turn(&StreamObject::rows))
      .def("finish", in_turn(&StreamObject::finish))
      .def_property_readonly("failure", in_turn(&StreamObject::failure))
      .def_property_readonly("columns", in_turn(&StreamObject::columns))
      .def_property_readonly("format", in_turn(&StreamObject::format))
      .def_property_readonly("summary", in_turn(&StreamObject::summary))
      .def_property_readonly("messages", in_turn(&StreamObject::messages))
      .def_property_readonly("status", in_turn(&StreamObject::status));
}

}  // namespace biss::python
