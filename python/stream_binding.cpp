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
    // A name of a file need not be UTF-8.
    py::object operator()(const std::string& text) const {
      return py::reinterpret_steal<py::object>(PyUnicode_DecodeUTF8(
          text.data(), static_cast<py::ssize_t>(text.size()), "surrogateescape"));
    }
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

// A Stream for Python: its samples have numbers, and one thread at a time is in it.
class StreamObject {
 public:
  StreamObject(const std::vector<std::string>& options, std::uint32_t sample_rate, bool fields,
               std::size_t beginning)
      : stream_(options, setup_of(sample_rate, fields, beginning)) {
    if (sample_rate != 0) clock_.emplace(hertz(sample_rate));
  }

  py::list edge(std::int64_t time, bool ma, bool slo) {
    check_time(time, 0);
    stream_.push(picoseconds(time), ma, slo);
    last_time_ = time;
    return decoded();
  }

  py::list edges(const py::array& times_array, const py::array& ma_array,
                 const py::array& slo_array) {
    const auto times = elements_of<std::int64_t>(times_array, "times");
    const auto [ma, slo] = levels(ma_array, slo_array, times.size());
    check_open();
    std::int64_t last = last_time_;
    for (std::size_t i = 0; i < times.size(); ++i) {
      if (times[i] < last) throw py::value_error(backwards(i));
      last = times[i];
    }
    for (std::size_t i = 0; i < times.size(); ++i) {
      stream_.push(picoseconds(times[i]), ma[i] != 0, slo[i] != 0);
    }
    last_time_ = last;
    return decoded();
  }

  py::list changes(const py::array& numbers_array, const py::array& ma_array,
                   const py::array& slo_array) {
    const auto numbers = elements_of<std::int64_t>(numbers_array, "numbers");
    const auto [ma, slo] = levels(ma_array, slo_array, numbers.size());
    check_clock();
    auto last = static_cast<std::int64_t>(next_sample_) - 1;
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      if (numbers[i] < last || numbers[i] < 0) throw py::value_error(backwards(i));
      last = numbers[i];
    }
    check_sample(last);
    for (std::size_t i = 0; i < numbers.size(); ++i) {
      const Picoseconds time = clock_->time_of(static_cast<std::uint64_t>(numbers[i]));
      stream_.push(time, ma[i] != 0, slo[i] != 0);
      last_time_ = time.count;
    }
    next_sample_ = static_cast<std::uint64_t>(last + 1);
    return decoded();
  }

  py::list change(std::int64_t number, bool ma, bool slo) {
    check_clock();
    if (number < 0 || number + 1 < static_cast<std::int64_t>(next_sample_)) {
      throw py::value_error(backwards(0));
    }
    check_sample(number);
    const Picoseconds time = clock_->time_of(static_cast<std::uint64_t>(number));
    stream_.push(time, ma, slo);
    last_time_ = time.count;
    next_sample_ = static_cast<std::uint64_t>(number) + 1;
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
    run([this] { stream_.decode(true); });
    return take();
  }

  py::list finish(std::optional<std::int64_t> end, std::optional<std::uint64_t> end_sample) {
    if (end_sample) {
      if (!clock_) throw py::value_error("end_sample: the decoder has no sample_rate");
      if (*end_sample > clock_->last_index()) throw py::value_error("end_sample: beyond 106 days");
      end = clock_->time_of(*end_sample).count;
    }
    const std::int64_t time = std::max(end.value_or(no_time), last_time_);
    run([&] { stream_.finish(picoseconds(time == no_time ? 0 : time)); });
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
      throw py::value_error(
          fmt::format("{} times, but {} levels of MA and {} of SLO", size, ma.size(), slo.size()));
    }
    return {ma, slo};
  }

  void check_open() const {
    if (stream_.ended()) throw py::value_error("the decoder is finished");
  }
  void check_time(std::int64_t time, std::size_t element) const {
    check_open();
    if (time < last_time_) throw py::value_error(backwards(element));
  }
  void check_clock() const {
    check_open();
    if (!clock_) throw py::value_error("the decoder has no sample_rate");
  }
  void check_sample(std::int64_t number) const {
    if (number >= 0 && static_cast<std::uint64_t>(number) > clock_->last_index()) {
      throw py::value_error("a sample beyond 106 days");
    }
  }

  template <class T>
  py::list take_samples(std::span<const T> samples, unsigned ma_bit, unsigned slo_bit) {
    if (ma_bit >= 8 * sizeof(T) || slo_bit >= 8 * sizeof(T) || ma_bit == slo_bit) {
      throw py::value_error(
          fmt::format("ma_bit {} and slo_bit {} are no two bits of a sample of "
                      "{} bits",
                      ma_bit, slo_bit, 8 * sizeof(T)));
    }
    if (samples.empty()) return decoded();
    check_sample(static_cast<std::int64_t>(next_sample_ + samples.size() - 1));
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const auto sample = static_cast<std::uint64_t>(samples[i]);
      const auto both =
          static_cast<std::uint8_t>((sample >> ma_bit & 1U) | (sample >> slo_bit & 1U) << 1U);
      if (std::exchange(last_levels_, both) == both) continue;
      stream_.push(clock_->time_of(next_sample_ + i), (both & 1U) != 0, (both & 2U) != 0);
    }
    next_sample_ += samples.size();
    last_time_ = clock_->time_of(next_sample_ - 1).count;
    return decoded();
  }

  py::list decoded() {
    if (stream_.waits()) return py::list();
    run([this] { stream_.decode(); });
    return take();
  }

  // While other threads of Python run.
  template <class Work>
  void run(Work work) {
    const py::gil_scoped_release released;
    const std::lock_guard lock(mutex_);
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

}  // namespace

void add_stream(py::module_& module) {
  py::class_<StreamObject>(module, "Stream")
      .def(py::init<const std::vector<std::string>&, std::uint32_t, bool, std::size_t>())
      .def("edge", &StreamObject::edge)
      .def("edges", &StreamObject::edges)
      .def("change", &StreamObject::change)
      .def("changes", &StreamObject::changes)
      .def("samples", &StreamObject::samples)
      .def("rows", &StreamObject::rows)
      .def("finish", &StreamObject::finish)
      .def_property_readonly("failure", &StreamObject::failure)
      .def_property_readonly("columns", &StreamObject::columns)
      .def_property_readonly("format", &StreamObject::format)
      .def_property_readonly("summary", &StreamObject::summary)
      .def_property_readonly("messages", &StreamObject::messages)
      .def_property_readonly("status", &StreamObject::status)
      .def_property_readonly("ended", &StreamObject::ended);
}

}  // namespace biss::python
