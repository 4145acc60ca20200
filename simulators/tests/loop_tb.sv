// Our master reads our encoder in Verilator: positions that the bench gives go around.
module loop_tb;
  timeunit 1ns; timeprecision 1ps;
  import biss_pkg::*;

  logic ma, slo;
  logic request = 0;
  int latches, requests;
  logic [35:0] position = 36'h123456789;

  biss_encoder #(
      .NAME("sender"),
      .SETTINGS("format=pos36,nE,nW,crc6 processing=0,5us timeout=20us")
  ) encoder (
      .ma,
      .slo
  );
  biss_master #(
      .NAME("reader"),
      .SETTINGS({"format=pos36,nE,nW,crc6 clock=1MHz,10MHz,80kHz timeout=20us ",
                 "line_delay=0,150ns,3us,0 cdm=0,0,0,1,1"})
  ) master (
      .*
  );

  always @(latches)
    if (latches > 0) begin
      biss_tb_value("reader", 0, longint'(position), 1, int'(position[0]), int'(position[1]));
      void'(biss_tb_compare("reader", "ok"));
    end

  initial begin
    #1000;
    for (int k = 1; k <= 30; k++) begin
      biss_tb_next("sender", 0, longint'(position), int'(position[0]), int'(position[1]));
      request = 1;
      @(requests) request = 0;
      biss_tb_value("sender", 0, longint'(position), 1, int'(position[0]), int'(position[1]));
      void'(biss_tb_compare("sender", "ok"));
      position = {position[34:0], position[35] ^ position[24]};
      #5000;
    end
    if (biss_tb_report("loop_tb") != 0) $fatal(1, "loop_tb: failed");
    $display("loop_tb: passed");
    $finish;
  end
endmodule
