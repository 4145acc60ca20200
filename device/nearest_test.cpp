#include "device/nearest.hpp"

#include <gtest/gtest.h>

namespace biss {
namespace nearest_test {}  // namespace nearest_test
}  // namespace biss
