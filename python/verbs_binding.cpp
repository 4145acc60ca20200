// The verbs in Python: captures in memory, results as NumPy arrays.
#include <pybind11/stl.h>

#include <cstdint>
#include <functional>
#include <map>
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

// The output of a verb.
struct VerbResult {
  verbs::ExitStatus status = verbs::ExitStatus::done;
  // The command's standard output; empty if `columns` has the rows.
  std::string output;
  std::string summary;
  std::vector<std::string> messages;
  std::vector<StoredColumn> columns;
};

// How a verb runs.
struct VerbSetup {
  // In place of files of these names.
  std::map<std::string, verbs::GivenCapture> captures;
  // The rows go to VerbResult::columns if the verb reads captures to a table.
  bool keep_columns = false;
  // As in MemoryHost::set_go_on(). After it has returned false, the result has no meaning.
  std::function<bool()> go_on = [] { return true; };
};

// The edges of MA and SLO in a capture, as in EdgeArrays; an element for each edge.
struct CaptureEdges {
  VerbResult result;
  std::string ma_name;
  std::string slo_name;
  Picoseconds sample_period{};
  Values<std::int64_t> times;
  Values<std::uint8_t> ma;
  Values<std::uint8_t> slo;
};

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

// Keeps the input and output of a verb in memory, and its rows on request.
class VerbHost final : public verbs::MemoryHost {
 public:
  VerbHost(const VerbSetup& setup, VerbResult& result)
      : keeps_columns_(setup.keep_columns), result_(result) {
    set_go_on(setup.go_on);
    for (const auto& [name, capture] : setup.captures) give(name, capture);
  }

  std::unique_ptr<report::TableWriter> keep_rows(std::span<const report::Column> columns) override {
    if (!keeps_columns_) return nullptr;
    return std::make_unique<KeptRows>(columns, result_.columns);
  }

  void end(verbs::ExitStatus status) {
    result_.status = status;
    result_.output = output_text();
    result_.summary = summary();
    result_.messages = lines();
  }

 private:
  bool keeps_columns_;
  VerbResult& result_;
};

// The levels of both lines, once both are known.
class EdgeCollector {
 public:
  EdgeCollector(const decode::Lines& lines, CaptureEdges& into) : lines_(lines), into_(into) {}

  // False at a level that is neither 0 nor 1.
  bool take(const wire::Edge& edge) {
    if (edge.line != lines_.ma && edge.line != lines_.slo) return true;
    if (edge.level == wire::Level::unknown) return false;
    const bool is_ma = edge.line == lines_.ma;
    const bool inverted = is_ma ? lines_.ma_inverted : lines_.slo_inverted;
    (is_ma ? ma_ : slo_) = (edge.level == wire::Level::high) != inverted;
    if (!ma_ || !slo_) return true;
    into_.times.push_back(edge.time.count);
    into_.ma.push_back(*ma_ ? 1 : 0);
    into_.slo.push_back(*slo_ ? 1 : 0);
    return true;
  }

 private:
  decode::Lines lines_;
  CaptureEdges& into_;
  std::optional<bool> ma_;
  std::optional<bool> slo_;
};

verbs::ExitStatus collect_edges(const verbs::DecodeOptions& options, CaptureEdges& edges,
                                verbs::Host& host) {
  verbs::CaptureArguments arguments = options.capture;
  arguments.identify = false;
  verbs::DecodedCapture capture(host);
  const verbs::ExitStatus opened = capture.open(arguments);
  if (opened != verbs::ExitStatus::done) return opened;
  if (capture.several()) return host.fail(verbs::ExitStatus::usage, "one capture at a time");
  if (!capture.next()) return capture.status();
  edges.ma_name = capture.ma_name();
  edges.slo_name = capture.slo_name();
  edges.sample_period = capture.input().sample_period();
  EdgeCollector collector(capture.lines().lines, edges);
  bool known = true;
  const bool read = capture.read_edges([&](std::span<const wire::Edge> block) {
    for (const wire::Edge& edge : block) known = known && collector.take(edge);
    return known;
  });
  if (!known) {
    return host.fail(verbs::ExitStatus::data_failed,
                     capture.input().name() + ": MA or SLO has a level that is neither 0 nor 1");
  }
  return read ? verbs::ExitStatus::done : host.fail(verbs::ExitStatus::io, capture.input().error());
}

// Runs a verb; `view` is not available. \param words,options see verbs::Command::run()
VerbResult run_verb(const std::vector<std::string>& words, const verbs::GivenOptions& options,
                    const VerbSetup& setup) {
  VerbResult result;
  VerbHost host(setup, result);
  verbs::Command command(host);
  verbs::add_verbs(command, words.empty() ? "" : words.front());
  host.end(command.run(words, options));
  return result;
}

// Reads the capture that the words name as for `biss decode`, and finds MA and SLO in it. A line that
// is inverted is inverted back. Also fails with `data_failed` if a level is neither 0 nor 1.
CaptureEdges read_edges(const std::vector<std::string>& words, const verbs::GivenOptions& given,
                        const VerbSetup& setup) {
  CaptureEdges edges;
  VerbHost host(setup, edges.result);
  verbs::Command command(host);
  verbs::DecodeOptions options;
  const verbs::Verb verb = command.add_verb(verbs::decode_text(), [&](verbs::Host& of_run) {
    return collect_edges(options, edges, of_run);
  });
  verbs::add_decode_options(verb, options);
  host.end(command.run(words, given));
  return edges;
}

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

// Whether to continue: Python may have received a signal.
bool goes_on() {
  const py::gil_scoped_acquire acquired;
  return PyErr_CheckSignals() == 0;
}

py::list messages_of(const VerbResult& result) {
  py::list messages;
  for (const std::string& message : result.messages) {
    // The text that the command prints: a terminal may show it in an exception.
    std::string printable;
    report::append_printable(printable, message);
    messages.append(text_object(printable));
  }
  return messages;
}

VerbSetup setup_of(const py::dict& captures, bool keep_columns) {
  VerbSetup setup;
  setup.keep_columns = keep_columns;
  for (const auto& [name, parts] : captures) {
    setup.captures.emplace(name.cast<std::string>(), capture_of(parts.cast<py::tuple>()));
  }
  return setup;
}

// Runs the work without the lock of Python. An exception of Python, for example from a signal,
// belongs to the thread and is raised there when the work has ended.
template <class Work>
auto without_lock(VerbSetup setup, Work work) {
  bool interrupted = false;
  setup.go_on = [&interrupted] {
    if (!interrupted) interrupted = !goes_on();
    return !interrupted;
  };
  auto result = [&] {
    const py::gil_scoped_release unlocked;
    return work(setup);
  }();
  if (interrupted) throw py::error_already_set();
  return result;
}

py::tuple run(const std::vector<std::string>& words, const verbs::GivenOptions& options,
              const py::dict& captures, bool keep_columns) {
  VerbResult result = without_lock(setup_of(captures, keep_columns), [&](const VerbSetup& setup) {
    return run_verb(words, options, setup);
  });
  py::list columns;
  for (StoredColumn& stored : result.columns) columns.append(tuple_of(stored));
  return py::make_tuple(static_cast<int>(result.status), py::bytes(result.output),
                        text_object(result.summary), messages_of(result), columns);
}

py::tuple edges(const std::vector<std::string>& words, const verbs::GivenOptions& options,
                const py::dict& captures) {
  CaptureEdges found = without_lock(setup_of(captures, false), [&](const VerbSetup& setup) {
    return read_edges(words, options, setup);
  });
  return py::make_tuple(static_cast<int>(found.result.status), messages_of(found.result),
                        text_object(found.ma_name), text_object(found.slo_name),
                        found.sample_period.count, array_of(std::move(found.times)),
                        array_of(std::move(found.ma)), array_of(std::move(found.slo)));
}

}  // namespace

void add_verbs(py::module_& module) {
  module.def("run", &run, py::arg("words"), py::arg("options"), py::arg("captures"),
             py::arg("keep_columns"));
  module.def("edges", &edges, py::arg("words"), py::arg("options"), py::arg("captures"));
}

}  // namespace biss::python
