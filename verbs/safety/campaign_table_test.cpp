#include "verbs/safety/experiments.hpp"

#include <gtest/gtest.h>

namespace biss::verbs {
namespace campaign_table_test {

TEST(CampaignTable, SigmaThatRoundsToZero_HasNoSign) {
  EXPECT_EQ(sigma_text(-0.004L), "0.00");
  EXPECT_EQ(sigma_text(0.004L), "0.00");
  EXPECT_EQ(sigma_text(-0.0L), "0.00");
  EXPECT_EQ(sigma_text(-0.006L), "-0.01");
  EXPECT_EQ(sigma_text(10.0L), "+10.00");
}

}  // namespace campaign_table_test
}  // namespace biss::verbs
