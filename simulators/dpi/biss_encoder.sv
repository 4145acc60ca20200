// Our encoder answers the master that drives MA. NAME is for the scoreboard of biss_pkg;
// docs/simulators.md describes SETTINGS.
module biss_encoder #(
    parameter string NAME = "encoder",
    parameter string SETTINGS = "format=pos26,nE,nW,crc6"
) (
    input  logic ma,
    output logic slo
);
  // The delays of an inlined module would count in the outer time unit, in Verilator 5.006.
  /*verilator no_inline_module*/
  timeunit 1ps; timeprecision 1ps;
  import biss_pkg::*;

  int id;
  longint wake = -1;  // the earliest call that is scheduled
  event due;

  task automatic step();
    longint deadline;
    if (wake >= 0 && longint'($time) >= wake) wake = -1;
    deadline = biss_tb_step_encoder(id, longint'($time), ma === 1'b0 ? 0 : 1);
    slo = biss_tb_level(id) != 0;
    if (deadline >= 0 && (wake < 0 || deadline < wake)) begin
      wake = deadline;
      wake_after(deadline - longint'($time));
    end
  endtask

  task automatic wake_after(longint delay_ps);
    fork
      begin
        #(delay_ps);
        ->due;
      end
    join_none
  endtask

  initial begin
    slo = 1'b1;
    id  = biss_tb_encoder(NAME, SETTINGS);
    if (id == 0) $fatal(1, "biss_encoder %s", NAME);
    step();
    #1 step();  // levels that other modules have set at time 0
    forever begin
      @(ma or due);
      step();
    end
  end
endmodule
