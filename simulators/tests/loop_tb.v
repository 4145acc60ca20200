// Our master reads our encoder in Icarus Verilog: positions that the bench gives go around.
`timescale 1ns / 10ps

module loop_tb;
  wire ma, slo;
  reg request = 0;
  wire [31:0] latches, requests;
  reg [35:0] position = 36'h123456789;

  biss_encoder #(
      .NAME("sender"),
      .SETTINGS("format=pos36,nE,nW,crc6 processing=0,5us timeout=20us")
  ) encoder (
      .ma (ma),
      .slo(slo)
  );
  biss_master #(
      .NAME("reader"),
      .SETTINGS({"format=pos36,nE,nW,crc6 clock=1MHz,10MHz,80kHz timeout=20us ",
                 "line_delay=0,150ns,3us,0 cdm=0,0,0,1,1"})
  ) master (
      .ma(ma),
      .slo(slo),
      .request(request),
      .latches(latches),
      .requests(requests)
  );

  always @(latches)
    if (latches > 0) begin
      $biss_value("reader", 0, position, position[0], position[1]);
      $biss_compare("reader", "ok");
    end

  integer k;
  initial begin
    #1000;
    for (k = 1; k <= 30; k = k + 1) begin
      $biss_next("sender", 0, position, position[0], position[1]);
      request = 1;
      @(requests) request = 0;
      $biss_value("sender", 0, position, position[0], position[1]);
      $biss_compare("sender", "ok");
      position = {position[34:0], position[35] ^ position[24]};
      #5000;
    end
    if ($biss_report("loop_tb") != 0) $fatal(1, "loop_tb: failed");
    $display("loop_tb: passed");
    $finish;
  end
endmodule
