// VCD files through the C interface.
#include <gtest/gtest.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>

#include "capi/biss_c_sim.h"

namespace biss::capi {
namespace vcd_test {

constexpr std::array<const char*, 2> names{"MA", "SLO at\tmaster"};

std::string path() { return testing::TempDir() + "biss_c_vcd_test.vcd"; }

std::string content() {
  std::ifstream file(path());
  std::stringstream text;
  text << file.rdbuf();
  return text.str();
}

void open(biss_vcd* vcd) {
  EXPECT_EQ(biss_vcd_init(vcd, path().c_str(), names.data(), names.size()), BISS_OK);
}

TEST(CVcd, Changes_AreWritten) {
  biss_vcd memory;
  biss_vcd* vcd = &memory;
  open(vcd);
  EXPECT_EQ(biss_vcd_put(vcd, 0, 1, false), BISS_OK);
  EXPECT_EQ(biss_vcd_put(vcd, 1'000, 0, false), BISS_OK);
  EXPECT_EQ(biss_vcd_put(vcd, 1'000, 1, true), BISS_OK);
  EXPECT_EQ(biss_vcd_put(vcd, 2'000, 1, true), BISS_OK);
  EXPECT_EQ(biss_vcd_close(vcd, 5'000), BISS_OK);
  EXPECT_EQ(content(),
            "$timescale 1ps $end\n$scope module biss $end\n$var wire 1 ! MA $end\n"
            "$var wire 1 \" SLO_at_master $end\n$upscope $end\n$enddefinitions $end\n"
            "#0\n1!\n1\"\n0\"\n#1000\n0!\n1\"\n#5000\n");
  std::remove(path().c_str());
}

TEST(CVcd, WrongCalls_AreRefusedByTheirCause) {
  biss_vcd memory;
  biss_vcd* vcd = &memory;
  EXPECT_EQ(biss_vcd_init(vcd, nullptr, names.data(), 2), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_vcd_init(vcd, path().c_str(), nullptr, 2), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_vcd_init(nullptr, path().c_str(), names.data(), 2), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_vcd_init(vcd, path().c_str(), names.data(), 0), BISS_BAD_SETUP);
  EXPECT_EQ(biss_vcd_init(vcd, path().c_str(), names.data(), 65), BISS_BAD_SETUP);
  const std::array<const char*, 2> empty{"MA", ""};
  EXPECT_EQ(biss_vcd_init(vcd, path().c_str(), empty.data(), 2), BISS_BAD_SETUP);
  EXPECT_EQ(biss_vcd_init(vcd, "/no/such/folder/line.vcd", names.data(), 2), BISS_FILE);
  EXPECT_EQ(biss_vcd_put(vcd, 0, 0, false), BISS_BAD_HANDLE);
  open(vcd);
  EXPECT_EQ(biss_vcd_put(vcd, 10, 2, false), BISS_BAD_SETUP);
  EXPECT_EQ(biss_vcd_put(vcd, -1, 0, false), BISS_TIME_RANGE);
  EXPECT_EQ(biss_vcd_put(vcd, 10, 0, false), BISS_OK);
  EXPECT_EQ(biss_vcd_put(vcd, 9, 0, true), BISS_TIME_BACKWARDS);
  EXPECT_EQ(biss_vcd_close(vcd, -1), BISS_TIME_RANGE);
  EXPECT_EQ(biss_vcd_put(vcd, 20, 0, true), BISS_BAD_HANDLE);
  EXPECT_EQ(biss_vcd_close(vcd, 30), BISS_BAD_HANDLE);
  EXPECT_EQ(biss_vcd_put(nullptr, 20, 0, true), BISS_NULL_ARGUMENT);
  EXPECT_EQ(biss_vcd_close(nullptr, 0), BISS_OK);
  EXPECT_TRUE(content().ends_with("#10\n0!\n"));
  std::remove(path().c_str());
}

TEST(CVcd, FullDisk_IsReported) {
  biss_vcd memory;
  biss_vcd* vcd = &memory;
  ASSERT_EQ(biss_vcd_init(vcd, "/dev/full", names.data(), 2), BISS_OK);
  errno = 0;
  EXPECT_EQ(biss_vcd_close(vcd, 100), BISS_FILE);
  EXPECT_EQ(errno, ENOSPC);
}

TEST(CVcd, FullDisk_HasItsReasonInEveryCall) {
  biss_vcd memory;
  biss_vcd* vcd = &memory;
  ASSERT_EQ(biss_vcd_init(vcd, "/dev/full", names.data(), names.size()), BISS_OK);
  std::int64_t time = 0;
  biss_status status = BISS_OK;
  while (status == BISS_OK && ++time < 100'000) status = biss_vcd_put(vcd, time, 0, time % 2 == 0);
  EXPECT_EQ(status, BISS_FILE);
  EXPECT_EQ(errno, ENOSPC);
  errno = 0;
  EXPECT_EQ(biss_vcd_put(vcd, time + 1, 1, false), BISS_FILE);
  EXPECT_EQ(errno, ENOSPC);
  errno = 0;
  EXPECT_EQ(biss_vcd_close(vcd, time + 2), BISS_FILE);
  EXPECT_EQ(errno, ENOSPC);
  const std::string longer(100'000, 'a');
  const char* const name = longer.c_str();
  errno = 0;
  EXPECT_EQ(biss_vcd_init(vcd, "/dev/full", &name, 1), BISS_FILE);
  EXPECT_EQ(errno, ENOSPC);
  EXPECT_EQ(biss_vcd_put(vcd, 0, 0, false), BISS_BAD_HANDLE);
}

}  // namespace vcd_test
}  // namespace biss::capi
