// The parts of the extension module biss._core.
#pragma once

#include <pybind11/pybind11.h>

namespace biss::python {

void add_verbs(pybind11::module_& module);
void add_stream(pybind11::module_& module);
void add_frames(pybind11::module_& module);

}  // namespace biss::python
