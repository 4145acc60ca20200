#include "python/module.hpp"

PYBIND11_MODULE(_core, module) {
  module.doc() = "What the package biss is made of. Use the package.";
  biss::python::add_verbs(module);
  biss::python::add_stream(module);
  biss::python::add_frames(module);
  module.attr("version") = BISS_VERSION;
}
