// Tables as HDF5. Separate from the room: the target is biss_report_hdf5, and nothing else in it
// needs the library.
#pragma once

#include <memory>
#include <span>

#include "report/sink.hpp"
#include "report/table.hpp"

namespace biss::report {

/// A writer of HDF5 that MATLAB and Octave load as a file of version 7.3. Each column is a data set
/// of its name, a row of HDF5 and so a column of MATLAB, with the attributes `unit`, `MATLAB_class`
/// and, if it is not NaN, `absent_value`. docs/decode.md describes the types.
///
/// Rows are collected to blocks of 16384; the texts of a column are kept in memory, so a column
/// should have few different ones. The same rows always give the same file. The columns are copied;
/// the sink must outlive the writer. If the library fails, the writer reports the cause to the
/// sink.
/// \pre a column of text takes only text; a value has at most the bits of its column
std::unique_ptr<TableWriter> make_hdf5_writer(std::span<const Column> columns, FileSink& sink);

}  // namespace biss::report
