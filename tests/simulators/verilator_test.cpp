// FST of Verilator. Where it is missing, the test reports itself as skipped.
#include <gtest/gtest.h>

#include <string>

#include "capture/test_peers.hpp"

namespace biss::capture::verilator_test {

constexpr const char* verilog = R"(`timescale 1ns/1ps
module top(input wire MA, output reg SLO, output reg [7:0] bus);
  reg [5:0] n = 0;
  reg [11:0] position = 12'ha5c;
  always @(posedge MA) begin n <= n + 1; SLO <= position[n % 12]; bus <= bus + 1; end
  wire copy;
  assign copy = MA;
endmodule
)";

constexpr const char* program =
    "#include \"verilated.h\"\n#include \"Vtop.h\"\n"
    "#ifdef FST\n#include \"verilated_fst_c.h\"\nusing Trace = VerilatedFstC;\n"
    "#else\n#include \"verilated_vcd_c.h\"\nusing Trace = VerilatedVcdC;\n#endif\n"
    R"(int main(int, char** argv) {
  VerilatedContext context;
  context.traceEverOn(true);
  Vtop top(&context);
  Trace trace;
  top.trace(&trace, 99);
  trace.open(argv[1]);
  top.MA = 1;
  for (int i = 0; i < 4000; ++i) {
    if (i > 20) top.MA = !top.MA;
    top.eval();
    trace.dump(context.time());
    if (i % 700 == 699) trace.flush();  // ends a block of an FST
    context.timeInc(i % 90 == 60 ? 1000000 : 50500);
  }
  trace.close();
}
)";

TEST(Verilator, FstOfARun_HasTheEdgesOfItsVcd) {
  if (!runs("verilator --version")) GTEST_SKIP() << "no verilator: scripts/install-packages test";
  const Folder folder;
  folder.file("top.v", verilog);
  folder.file("main.cpp", program);
  const auto trace = [&](const std::string& options, const std::string& file) {
    return runs("cd " + folder.path(".") +
                " && verilator --cc --exe --build -Wno-fatal --top-module top " + options +
                " top.v main.cpp && ./obj_" + file + "/Vtop trace." + file);
  };
  ASSERT_TRUE(trace("--trace -CFLAGS -O0 --Mdir obj_vcd", "vcd"));
  ASSERT_TRUE(trace("--trace-fst -CFLAGS '-O0 -DFST' --Mdir obj_fst", "fst"));
  const Changes vcd = changes_of(folder.path("trace.vcd"));
  EXPECT_EQ(changes_of(folder.path("trace.fst")), vcd);
  EXPECT_GT(vcd.at("copy").size(), 3'000U);
  EXPECT_GT(vcd.at("SLO").size(), 1'000U);
}

}  // namespace biss::capture::verilator_test
