// The functions of simulators/testbench.h for SystemVerilog, by DPI-C. Link libbiss_testbench.
package biss_pkg;
  timeunit 1ps; timeprecision 1ps;

  import "DPI-C" function int biss_tb_encoder(
    input string name,
    input string settings
  );
  import "DPI-C" function int biss_tb_master(
    input string name,
    input string settings
  );
  import "DPI-C" function longint biss_tb_step_encoder(
    input int id,
    input longint now_ps,
    input int ma
  );
  import "DPI-C" function longint biss_tb_step_master(
    input int id,
    input longint now_ps,
    input int slo,
    input int request
  );
  import "DPI-C" function int biss_tb_level(input int id);
  import "DPI-C" function int biss_tb_latches(input int id);
  import "DPI-C" function int biss_tb_requests(input int id);

  // The next frame of this encoder.
  import "DPI-C" function void biss_tb_next(
    input string name,
    input int channel,
    input longint position,
    input int nE,
    input int nW
  );
  // The values that the design has read, or was given; then biss_tb_compare().
  import "DPI-C" function void biss_tb_value(
    input string name,
    input int channel,
    input longint position,
    input int known,
    input int nE,
    input int nW
  );
  import "DPI-C" function int biss_tb_compare(
    input string name,
    input string cause
  );
  // Returns the number of mismatches.
  import "DPI-C" function int biss_tb_report(input string path);
endpackage
