// NumPy arrays in and out, without a copy.
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "python/module.hpp"

namespace biss::python {

namespace py = pybind11;

/// A text that need not be UTF-8, as the name of a file.
inline py::object text_object(std::string_view text) {
  return py::reinterpret_steal<py::object>(
      PyUnicode_DecodeUTF8(text.data(), static_cast<py::ssize_t>(text.size()), "surrogateescape"));
}

/// Raises UsageError unless the array has one dimension and no gap between its elements.
inline void check_shape(const py::array& array, const char* name) {
  if (array.ndim() != 1) throw UsageError(std::string(name) + ": not one-dimensional");
  if (array.size() > 1 && array.strides(0) != array.itemsize()) {
    throw UsageError(std::string(name) + ": not contiguous; use numpy.ascontiguousarray()");
  }
}

/// The elements of a one-dimensional array of exactly this type, not copied.
/// Raises TypeError for another type, UsageError for another shape or a gap between elements.
template <class T>
std::span<const T> elements_of(const py::array& array, const char* name) {
  if (!py::isinstance<py::array_t<T>>(array)) {
    throw py::type_error(std::string(name) + ": the array has the type " +
                         py::str(array.dtype()).cast<std::string>() + "; " +
                         py::str(py::dtype::of<T>()).cast<std::string>() + " is needed");
  }
  check_shape(array, name);
  return {static_cast<const T*>(array.data()), static_cast<std::size_t>(array.size())};
}

/// The same for levels: bool or uint8.
inline std::span<const std::uint8_t> levels_of(const py::array& array, const char* name) {
  static_assert(sizeof(bool) == 1);
  if (!py::isinstance<py::array_t<bool>>(array)) return elements_of<std::uint8_t>(array, name);
  const std::span<const bool> levels = elements_of<bool>(array, name);
  return {reinterpret_cast<const std::uint8_t*>(levels.data()), levels.size()};
}

/// An array that owns the values.
template <class T, class Allocator>
py::array array_of(std::vector<T, Allocator> values, std::vector<py::ssize_t> shape = {},
                   const py::dtype& type = py::dtype::of<T>()) {
  using Vector = std::vector<T, Allocator>;
  auto kept = std::make_unique<Vector>(std::move(values));
  if (shape.empty()) shape.push_back(static_cast<py::ssize_t>(kept->size()));
  const T* const data = kept->data();
  const py::capsule owner(kept.release(),
                          [](void* memory) { delete static_cast<Vector*>(memory); });
  return py::array(type, std::move(shape), data, owner);
}

}  // namespace biss::python
