#include "verbs/common/access_option.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "verbs/simulate/registers.hpp"

namespace biss::verbs {
namespace access_option_test {

using sim::AccessKind;
using sim::ControlAccess;
using testing::ElementsAre;
using testing::HasSubstr;

ControlAccess access_of(const std::string& text) {
  const auto access = read_access(text);
  EXPECT_TRUE(access.has_value()) << text;
  return access.value_or(ControlAccess{});
}

TEST(AccessOption, RegistersIdAndCycle_AreRead) {
  const ControlAccess one = access_of("read:0x42");
  EXPECT_EQ(one.kind, AccessKind::read);
  EXPECT_EQ(one.slave, 0);
  EXPECT_EQ(one.address, 0x42);
  EXPECT_EQ(one.size, 1);
  EXPECT_EQ(one.not_before, 0U);
  const ControlAccess most = access_of("7/read:64,64@1000");
  EXPECT_EQ(most.slave, 7);
  EXPECT_EQ(most.address, 64);
  EXPECT_EQ(most.size, 64);
  EXPECT_EQ(most.not_before, 1000U);
  const ControlAccess write = access_of("1/write:0x48=01fF@3");
  EXPECT_EQ(write.kind, AccessKind::write);
  EXPECT_EQ(write.slave, 1);
  EXPECT_THAT(write.data, ElementsAre(0x01, 0xFF));
  EXPECT_EQ(write.not_before, 3U);
}

TEST(AccessOption, CommandsByNameAndNumber_AreRead) {
  const ControlAccess all = access_of("command:control");
  EXPECT_EQ(all.kind, AccessKind::broadcast);
  EXPECT_EQ(all.command, ControlCommand::control);
  const ControlAccess some = access_of("0,2/command:3,any");
  EXPECT_EQ(some.kind, AccessKind::command);
  EXPECT_EQ(some.slaves, 0b101);
  EXPECT_EQ(some.command, ControlCommand::user);
  EXPECT_EQ(some.execute_if, ExecuteIf::any_accepts);
  EXPECT_EQ(access_of("0/command:channels").execute_if, ExecuteIf::all_accept);
  EXPECT_EQ(access_of("0/command:bypass,always").execute_if, ExecuteIf::always);
}

TEST(AccessOption, WhatIsNoAccess_IsRefusedWithItsText) {
  for (const char* text : {"",
                           "read",
                           "read:",
                           "read:128",
                           "read:0x80",
                           "read:-1",
                           "read:0,0",
                           "read:0,65",
                           "read:0,",
                           "read:0x7F,2",
                           "8/read:0",
                           "/read:0",
                           "a/read:0",
                           "0,1/read:0",
                           "read:0@",
                           "read:0@x",
                           "write:0",
                           "write:0=",
                           "write:0=1",
                           "write:0=0g",
                           "write:0=010",
                           "write:0x7F=0102",
                           "write:0=0x01",
                           "command:",
                           "command:4",
                           "command:none",
                           "command:0,all",
                           "0/command:0,",
                           "0/command:0,most",
                           "erase:0",
                           "READ:0"}) {
    const auto access = read_access(text);
    ASSERT_FALSE(access.has_value()) << text;
    EXPECT_THAT(access.error(), HasSubstr(std::string("--access: '") + text + "'"));
  }
  EXPECT_FALSE(read_access("write:0=" + std::string(130, '0')).has_value());
  EXPECT_TRUE(read_access("write:0=" + std::string(128, '0')).has_value());
}

TEST(AccessOption, LeastCycles_CountZerosOnceAndWaiting) {
  EXPECT_EQ(least_cycles({}), 0U);
  EXPECT_EQ(least_cycles({access_of("read:0")}), 47U);
  EXPECT_EQ(least_cycles({access_of("read:0,64")}), 929U);
  EXPECT_EQ(least_cycles({access_of("read:0"), access_of("command:0")}), 47U + 18U);
  EXPECT_EQ(least_cycles({access_of("0/command:0@500"), access_of("write:0=00")}), 500U + 25 + 33);
}

}  // namespace access_option_test
}  // namespace biss::verbs
