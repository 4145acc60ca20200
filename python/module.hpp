// The parts of the extension module biss._core.
#pragma once

#include <pybind11/pybind11.h>

#include <stdexcept>

namespace biss::python {

/// An argument is wrong: biss.UsageError in Python.
struct UsageError : std::invalid_argument {
  using std::invalid_argument::invalid_argument;
};

void add_verbs(pybind11::module_& module);
void add_stream(pybind11::module_& module);
void add_frames(pybind11::module_& module);

}  // namespace biss::python
