// Our master reads the encoder that drives SLO, while `request` is 1. `latches` counts the first
// rising edges of MA, when the encoder takes its position, and `requests` the requests that have
// ended. NAME is for the scoreboard of biss_pkg; docs/simulators.md describes SETTINGS.
module biss_master #(
    parameter string NAME = "master",
    parameter string SETTINGS = "format=pos26,nE,nW,crc6"
) (
    output logic ma,
    input  logic slo,
    input  logic request,
    output int   latches,
    output int   requests
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
    deadline = biss_tb_step_master(id, longint'($time), slo === 1'b0 ? 0 : 1,
                                   request === 1'b1 ? 1 : 0);
    latches = biss_tb_latches(id);
    ma = biss_tb_level(id) != 0;
    requests = biss_tb_requests(id);
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
    ma = 1'b1;
    latches = 0;
    requests = 0;
    id = biss_tb_master(NAME, SETTINGS);
    if (id == 0) $fatal(1, "biss_master %s", NAME);
    step();
    #1 step();  // levels that other modules have set at time 0
    forever begin
      @(slo or request or due);
      step();
    end
  end
endmodule
