// Our encoder answers biss_line_master in Icarus Verilog, and the scoreboard compares what it reads.
`timescale 1ps / 1ps
`include "master_settings.vh"

module master_tb;
  parameter REQUESTS = 240;
  parameter POSITION_BITS = 26;

  localparam SETTINGS = `MASTER_SETTINGS;

  reg clk = 0;
  always #6250 clk = !clk;
  reg reset = 1;
  reg start = 0;
  wire ready, ma, slo, valid, nE, nW;
  wire [2:0] cause;
  wire [POSITION_BITS-1:0] position;

  biss_line_master #(
      .POSITION_BITS(POSITION_BITS)
  ) dut (
      .clk(clk),
      .reset(reset),
      .start(start),
      .ready(ready),
      .ma(ma),
      .slo(slo),
      .valid(valid),
      .cause(cause),
      .position(position),
      .nE(nE),
      .nW(nW)
  );

  biss_encoder #(
      .NAME("axis"),
      .SETTINGS(SETTINGS)
  ) encoder (
      .ma (ma),
      .slo(slo)
  );

  task compare;
    begin
      $biss_value("axis", 0, position, nE, nW);
      case (cause)
        0: $biss_compare("axis", "ok");
        1: $biss_compare("axis", "no_response");
        2: $biss_compare("axis", "response_range");
        3: $biss_compare("axis", "no_start");
        4: $biss_compare("axis", "cds");
        5: $biss_compare("axis", "crc");
        default: $biss_compare("axis", "stop_bit");
      endcase
    end
  endtask

  integer done = 0;
  integer waited = 0;
  integer failures;
  always @(posedge clk) begin
    waited = valid === 1'b1 ? 0 : waited + 1;
    if (valid) begin
      compare;
      done = done + 1;
    end
    // A design that hangs is not waited for.
    if (done == REQUESTS || waited == 100000) begin
      failures = $biss_report("master_tb");
      if (failures != 0) $fatal(1, "master_tb: failed");  // the exit status is not 0
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
