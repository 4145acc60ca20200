#include "report/table.hpp"

#include "report/writers.hpp"

namespace biss::report {

std::optional<Format> format_by_name(std::string_view name) {
  for (std::size_t i = 0; i < format_names.size(); ++i) {
    if (format_names[i] == name) return static_cast<Format>(i);
  }
  return std::nullopt;
}

std::unique_ptr<TableWriter> make_table_writer(Format format, std::span<const Column> columns,
                                               TextSink& sink, TableOptions options) {
  switch (format) {
    case Format::csv:
      return make_csv_writer(columns, sink);
    case Format::jsonl:
      return make_jsonl_writer(columns, sink);
    case Format::vcd:
      return make_vcd_writer(columns, sink);
    case Format::table:
    case Format::hdf5:
      break;
  }
  return make_eye_writer(columns, sink, options);
}

}  // namespace biss::report
