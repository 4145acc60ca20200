// Our encoder answers biss_line_master in Verilator, and the scoreboard compares what it reads.
`include "master_settings.vh"

module master_tb;
  timeunit 1ps; timeprecision 1ps;
  import biss_pkg::*;

  localparam int REQUESTS = 240;
  localparam int POSITION_BITS = 26;

  logic clk = 0;
  always #6250 clk = !clk;
  logic reset = 1;
  logic start = 0;
  logic ready, ma, slo, valid, nE, nW;
  logic [2:0] cause;
  logic [POSITION_BITS-1:0] position;

  biss_line_master #(
      .POSITION_BITS(POSITION_BITS)
  ) dut (
      .*
  );

  biss_encoder #(
      .NAME("axis"),
      .SETTINGS(`MASTER_SETTINGS)
  ) encoder (
      .ma,
      .slo
  );

  function automatic string cause_name();
    case (cause)
      0: return "ok";
      1: return "no_response";
      2: return "response_range";
      3: return "no_start";
      4: return "cds";
      5: return "crc";
      default: return "stop_bit";
    endcase
  endfunction

  int done = 0;
  int waited = 0;
  always @(posedge clk) begin
    waited = valid ? 0 : waited + 1;
    if (valid) begin
      biss_tb_value("axis", 0, longint'(position), 1, int'(nE), int'(nW));
      void'(biss_tb_compare("axis", cause_name()));
      done = done + 1;
    end
    // A design that hangs is not waited for.
    if (done == REQUESTS || waited == 100000) begin
      if (biss_tb_report("master_tb") != 0) $fatal(1, "master_tb: failed");  // exit status not 0
      $display("master_tb: passed");
      $finish;
    end
  end

  initial begin
    repeat (4) @(posedge clk);
    reset = 0;
    start = 1;  // whenever it is ready
  end
endmodule
