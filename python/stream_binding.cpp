// The decoder in Python that is fed piece by piece.
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <bit>
#include <limits>
#include <mutex>
#include <optional>
#include <variant>

#include "capture/samples.hpp"
#include "python/module.hpp"
#include "python/numpy_arrays.hpp"
#include "python/stream.hpp"

namespace biss::python {
namespace {

constexpr std::int64_t no_time = std::numeric_limits<std::int64_t>::min();

py::object object_of(const StreamValue& value) {
  struct Convert {
    py::object operator()(std::monostate) const { return py::none(); }
    py::object operator()(std::uint64_t number) const { return py::int_(number); }
    py::object operator()(std::int64_t number) const { return py::int_(number); }
    py::object operator()(double number) const { return py::float_(number); }
    py::object operator()(Picoseconds time) const {
      return py::float_(static_cast<double>(time.count) / 1000.0);
    }
    py::object operator()(const std::string& text) const { return text_object(text); }
  };
  return std::visit(Convert(), value);
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

// A Stream for Python: its samples have numbers. One thread at a time is in it; see in_turn().
class StreamObject {
 public:
  // While a thread has it, the others wait. Other threads of Python run while it waits.
  class Turn {
   public:
    explicit Turn(StreamObject& stream) : lock_(stream.mutex_, std::try_to_lock) {
      if (lock_.owns_lock()) return;
      const py::gil_scoped_release released;
      lock_.lock();
    }

   private:
    std::unique_lock<std::mutex> lock_;
  };

  StreamObject(const verbs::GivenOptions& options, std::uint32_t sample_rate, bool fields,
               std::size_t beginning)
      : stream_(options, setup_of(sample_rate, fields, beginning)) {
    if (sample_rate != 0) clock_.emplace(hertz(sample_rate));
  }

  py::list edges(const py::array& times_array, const py::array& ma_array,
                 const py::array& slo_array) {
    const auto times = elements_of<std::int64_t>(times_array, "times");
    const auto [ma, slo] = levels(ma_array, slo_array, times.size());
    check_open();
    std::int64_t last = last_time_;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] < last) throw UsageError(backwards(i));
      last = times[i];
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
      push(picoseconds(times[i]), ma[i] != 0, slo[i] != 0);
    }
    return decoded();
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
    if (!numbers.empty()) check_time(time_of(numbers[0]));
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      push(time_of(numbers[i]), ma[i] != 0, slo[i] != 0);
    }
    next_sample_ = static_cast<std::uint64_t>(last + 1);
    return decoded();
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

  py::list rows() {
    unlocked([this] { stream_.decode(true); });
    return take();
  }

  py::list finish(std::optional<std::int64_t> end, std::optional<std::uint64_t> end_sample) {
    if (end_sample) {
      if (!clock_) throw UsageError("end_sample: the decoder has no sample_rate");
      if (*end_sample > clock_->last_index()) throw UsageError("end_sample: beyond 106 days");
      end = clock_->time_of(*end_sample).count;
    }
    const std::int64_t time = std::max(end.value_or(no_time), last_time_);
    unlocked([&] { stream_.finish(picoseconds(time == no_time ? 0 : time)); });
    return take();
  }

  py::object failure() const {
    if (!stream_.failure()) return py::none();
    return py::make_tuple(static_cast<int>(stream_.failure()->status), stream_.failure()->text);
  }
  py::list columns() const {
    py::list columns;
    for (const report::Column& column : stream_.columns()) {
      const bool time = column.kind == report::Kind::nanoseconds;
      columns.append(py::make_tuple(column.name, time ? "ns" : column.value_unit));
    }
    return columns;
  }
  std::string format() const { return stream_.format(); }
  std::string summary() const { return stream_.summary(); }
  std::vector<std::string> messages() const { return stream_.messages(); }
  int status() const { return static_cast<int>(stream_.status()); }
  bool ended() const { return stream_.ended(); }

 private:
  static StreamSetup setup_of(std::uint32_t rate, bool fields, std::size_t beginning) {
    StreamSetup setup{.fields = fields, .beginning = beginning};
    if (rate != 0) setup.sample_period = capture::longest_period(hertz(rate));
    return setup;
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
    if (stream_.ended()) throw UsageError("the decoder is finished");
  }
  // Checks the time of the first edge or sample of a call.
  void check_time(Picoseconds time) const {
    if (time.count < last_time_) throw UsageError(backwards(0));
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

  Picoseconds time_of(std::int64_t number) const {
    return clock_->time_of(static_cast<std::uint64_t>(number));
  }

  void push(Picoseconds time, bool ma, bool slo) {
    stream_.push(time, ma, slo);
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
    check_time(clock_->time_of(next_sample_));
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

  py::list decoded() {
    if (stream_.waits()) return py::list();
    unlocked([this] { stream_.decode(); });
    return take();
  }

  // While other threads of Python run.
  template <class Work>
  static void unlocked(Work work) {
    const py::gil_scoped_release released;
    work();
  }

  py::list take() {
    py::list rows;
    for (const StreamRow& row : stream_.take_rows()) {
      py::tuple values(row.values.size());
      for (std::size_t i = 0; i < row.values.size(); ++i) values[i] = object_of(row.values[i]);
      py::list fields;
      for (const StreamField& field : row.fields) fields.append(tuple_of(field));
      rows.append(py::make_tuple(values, row.begin.count, row.end.count, fields));
    }
    return rows;
  }

  Stream stream_;
  std::mutex mutex_;
  std::optional<capture::SampleClock> clock_;
  std::uint64_t next_sample_ = 0;
  std::uint8_t last_levels_ = 0xFF;
  std::int64_t last_time_ = no_time;
};

// The method of a StreamObject, in its turn.
template <class Result, class... Arguments>
auto in_turn(Result (StreamObject::*method)(Arguments...)) {
  return [method](StreamObject& stream, Arguments... arguments) {
    const StreamObject::Turn turn(stream);
    return (stream.*method)(arguments...);
  };
}

template <class Result>
auto in_turn(Result (StreamObject::*method)() const) {
  return [method](StreamObject& stream) {
    const StreamObject::Turn turn(stream);
    return (stream.*method)();
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
      .def_property_readonly("status", in_turn(&StreamObject::status))
      .def_property_readonly("ended", in_turn(&StreamObject::ended));
}

}  // namespace biss::python
