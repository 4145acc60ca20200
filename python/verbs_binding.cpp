// The verbs in Python: captures in memory, results as NumPy arrays.
#include <pybind11/stl.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "capture/buffer.hpp"
#include "capture/bytes.hpp"
#include "capture/open.hpp"
#include "capture/samples.hpp"
#include "python/arrays.hpp"
#include "python/module.hpp"
#include "python/numpy_arrays.hpp"
#include "report/row_store.hpp"
#include "report/text.hpp"
#include "verbs/common/capture_input.hpp"
#include "verbs/common/host.hpp"
#include "verbs/decode/decode_run.hpp"

namespace biss::python {
namespace {

using report::Kind;

// Memory that NumPy takes over as it is.
template <class T>
using Values = std::vector<T, capture::Unfilled<T>>;
using StoredColumn = report::StoredColumn<Values>;

class KeptRows final : public report::RowStore<Values> {
 public:
  KeptRows(std::span<const report::Column> columns, std::vector<StoredColumn>& into)
      : RowStore(columns), into_(into) {}

  bool finish() override {
    into_ = take_columns();
    return true;
  }

 private:
  std::vector<StoredColumn>& into_;
};

verbs::GivenCapture samples_capture(const py::array& array, std::uint32_t rate) {
  check_shape(array, "samples");
  const std::string_view bytes(static_cast<const char*>(array.data()),
                               static_cast<std::size_t>(array.nbytes()));
  const verbs::RawSamples raw{.rate = hertz(rate),
                              .bytes = static_cast<std::uint64_t>(array.itemsize())};
  return {[bytes, raw](const verbs::InputArguments& arguments) {
    return capture::open_raw(capture::memory_bytes(bytes),
                             verbs::layout_of(raw, arguments.ma, arguments.slo));
  }};
}

verbs::GivenCapture edges_capture(const py::array& times, const py::array& ma, const py::array& slo,
                                  std::int64_t period) {
  const EdgeArrays arrays{elements_of<std::int64_t>(times, "times"), levels_of(ma, "ma"),
                          levels_of(slo, "slo"), picoseconds(period)};
  if (arrays.ma.size() != arrays.times.size() || arrays.slo.size() != arrays.times.size()) {
    throw UsageError("times, ma and slo have different lengths");
  }
  return {[arrays](const verbs::InputArguments&) { return open_arrays(arrays); }};
}

// The content of a file; its name gives the format if the content does not.
verbs::GivenCapture bytes_capture(const py::bytes& bytes, const std::string& name) {
  const std::string_view text = bytes;
  return {[text, name](const verbs::InputArguments& arguments) {
    capture::OpenOptions options{.no_verify = arguments.no_verify, .analog = arguments.raw.analog};
    if (arguments.raw.rate) {
      options.raw = verbs::layout_of(arguments.raw, arguments.ma, arguments.slo);
    }
    return capture::open_capture(capture::memory_bytes(text), name, options);
  }};
}

// A capture as the package describes it: (samples, rate), (times, ma, slo, period) or
// (bytes, name, None).
verbs::GivenCapture capture_of(const py::tuple& parts) {
  if (parts.size() == 3) {
    return bytes_capture(parts[0].cast<py::bytes>(), parts[1].cast<std::string>());
  }
  if (parts.size() == 2) {
    return samples_capture(parts[0].cast<py::array>(), parts[1].cast<std::uint32_t>());
  }
  return edges_capture(parts[0].cast<py::array>(), parts[1].cast<py::array>(),
                       parts[2].cast<py::array>(), parts[3].cast<std::int64_t>());
}

py::array values_of(StoredColumn& stored) {
  const auto rows = static_cast<py::ssize_t>(stored.numbers.size() / stored.lanes);
  switch (stored.column.kind) {
    case Kind::flag:
      return array_of(std::move(stored.flags));
    case Kind::signed_integer:
    case Kind::nanoseconds:
      return array_of(std::move(stored.numbers), {rows}, py::dtype::of<std::int64_t>());
    case Kind::real:
      return array_of(std::move(stored.numbers), {rows}, py::dtype::of<double>());
    case Kind::bits:
      if (stored.lanes == 1) return array_of(std::move(stored.numbers));
      return array_of(std::move(stored.numbers), {rows, static_cast<py::ssize_t>(stored.lanes)});
    default:
      return array_of(std::move(stored.numbers));
  }
}

// (name, kind, unit, values, absent or None, texts, counts of bits or None, bits of the widest value or 0,
// role)
py::tuple tuple_of(StoredColumn& stored) {
  py::list texts;
  for (const std::string& text : stored.texts) texts.append(text_object(text));
  py::object absent = py::none();
  if (!stored.absent.empty()) {
    absent = array_of(std::move(stored.absent), {}, py::dtype::of<bool>());
  }
  py::object counts = py::none();
  if (stored.column.kind == Kind::bits) counts = array_of(std::move(stored.bit_counts));
  const bool time = stored.column.kind == Kind::nanoseconds;
  return py::make_tuple(
      stored.column.name, report::kind_names[static_cast<std::size_t>(stored.column.kind)],
      time ? std::string("ns") : stored.column.value_unit, values_of(stored), absent, texts, counts,
      stored.column.bits, report::role_names[static_cast<std::size_t>(stored.column.role)]);
}

// Keeps the input and output of a verb in memory, and its rows on request.
class VerbHost final : public verbs::MemoryHost {
 public:
  // \param captures in place of files of these names
  explicit VerbHost(const py::dict& captures) {
    for (const auto& [name, parts] : captures) {
      give(name.cast<std::string>(), capture_of(parts.cast<py::tuple>()));
    }
  }

  std::unique_ptr<report::TableWriter> keep_rows(std::span<const report::Column> of_rows) override {
    if (!keep_columns) return nullptr;
    return std::make_unique<KeptRows>(of_rows, columns);
  }

  // Runs a command without the lock of Python. An exception of Python, for example from a signal,
  // belongs to the thread and is raised there when the command has ended.
  // \param words,options see verbs::Command::run()
  int run(verbs::Command& command, const std::vector<std::string>& words,
          const verbs::GivenOptions& options) {
    bool interrupted = false;
    set_go_on([&interrupted] {
      const py::gil_scoped_acquire locked;
      interrupted = interrupted || PyErr_CheckSignals() != 0;
      return !interrupted;
    });
    const verbs::ExitStatus status = [&] {
      const py::gil_scoped_release unlocked;
      return command.run(words, options);
    }();
    if (interrupted) throw py::error_already_set();
    return static_cast<int>(status);
  }

  // The lines as the command prints them: a terminal may show them in an exception.
  py::list messages() const {
    py::list messages;
    for (const std::string& line : lines()) {
      std::string printable;
      report::append_printable(printable, line);
      messages.append(text_object(printable));
    }
    return messages;
  }

  // The rows go to `columns` if the verb reads captures to a table.
  bool keep_columns = false;
  std::vector<StoredColumn> columns;
};

// Runs a verb; `view` is not available. The output is empty if the columns have the rows.
py::tuple run(const std::vector<std::string>& words, const verbs::GivenOptions& options,
              const py::dict& captures, bool keep_columns) {
  VerbHost host(captures);
  host.keep_columns = keep_columns;
  verbs::Command command(host);
  verbs::add_verbs(command, words.empty() ? "" : words.front());
  const int status = host.run(command, words, options);
  py::list columns;
  for (StoredColumn& stored : host.columns) columns.append(tuple_of(stored));
  return py::make_tuple(status, py::bytes(host.output_text()), text_object(host.summary()),
                        host.messages(), columns);
}

// The edges of MA and SLO in a capture, as in EdgeArrays; an element for each edge.
struct CaptureEdges {
  Picoseconds sample_period{};
  Values<std::int64_t> times;
  Values<std::uint8_t> ma;
  Values<std::uint8_t> slo;
};

// A line that is inverted is inverted back. Also fails if a level is neither 0 nor 1.
verbs::ExitStatus collect_edges(const verbs::CaptureArguments& arguments, CaptureEdges& edges,
                                verbs::Host& host) {
  verbs::DecodedCapture capture(host);
  const verbs::ExitStatus opened = capture.open(arguments);
  if (opened != verbs::ExitStatus::done) return opened;
  if (capture.several()) return host.fail(verbs::ExitStatus::usage, "one capture at a time");
  if (!capture.next()) return capture.status();
  edges.sample_period = capture.input().sample_period();
  const decode::Lines& lines = capture.lines().lines;
  std::optional<bool> ma;
  std::optional<bool> slo;
  bool known = true;
  const bool read = capture.read_edges([&](std::span<const wire::Edge> block) {
    for (const wire::Edge& edge : block) {
      if (edge.line != lines.ma && edge.line != lines.slo) continue;
      known = edge.level != wire::Level::unknown;
      if (!known) break;
      const bool is_ma = edge.line == lines.ma;
      const bool inverted = is_ma ? lines.ma_inverted : lines.slo_inverted;
      (is_ma ? ma : slo) = (edge.level == wire::Level::high) != inverted;
      if (!ma || !slo) continue;
      edges.times.push_back(edge.time.count);
      edges.ma.push_back(*ma ? 1 : 0);
      edges.slo.push_back(*slo ? 1 : 0);
    }
    return known;
  });
  if (!known) {
    return host.fail(verbs::ExitStatus::data_failed,
                     capture.input().name() + ": MA or SLO has a level that is neither 0 nor 1");
  }
  return read ? verbs::ExitStatus::done : host.fail(verbs::ExitStatus::io, capture.input().error());
}

// Reads the capture that the words name as for `biss decode`, and finds MA and SLO in it.
py::tuple edges(const std::vector<std::string>& words, const verbs::GivenOptions& given,
                const py::dict& captures) {
  VerbHost host(captures);
  verbs::Command command(host);
  verbs::DecodeOptions options;
  CaptureEdges found;
  const verbs::Verb verb = command.add_verb(verbs::decode_text(), [&](verbs::Host& of_run) {
    options.capture.identify = false;
    return collect_edges(options.capture, found, of_run);
  });
  verbs::add_decode_options(verb, options);
  const int status = host.run(command, words, given);
  return py::make_tuple(status, host.messages(), found.sample_period.count,
                        array_of(std::move(found.times)), array_of(std::move(found.ma)),
                        array_of(std::move(found.slo)));
}

}  // namespace

void add_verbs(py::module_& module) {
  module.def("run", &run, py::arg("words"), py::arg("options"), py::arg("captures"),
             py::arg("keep_columns"));
  module.def("edges", &edges, py::arg("words"), py::arg("options"), py::arg("captures"));
}

}  // namespace biss::python
