#include "python/module.hpp"

#include <exception>

namespace {

namespace py = pybind11;

void translate(std::exception_ptr thrown) {
  try {
    if (thrown) std::rethrow_exception(thrown);
  } catch (const biss::python::UsageError& error) {
    const py::object type = py::module_::import("biss._errors").attr("UsageError");
    PyErr_SetString(type.ptr(), error.what());
  }
}

}  // namespace

PYBIND11_MODULE(_core, module) {
  py::register_local_exception_translator(&translate);
  module.doc() = "The parts of the package biss. Use the package.";
  biss::python::add_verbs(module);
  biss::python::add_stream(module);
  biss::python::add_frames(module);
  module.attr("version") = BISS_VERSION;
}
