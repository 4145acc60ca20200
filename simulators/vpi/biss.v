// An encoder and a master of `biss` as modules, for simulators with VPI: load the module biss.vpi.
// docs/simulators.md describes SETTINGS.
`timescale 1ps / 1ps

// Answers the master that drives MA. NAME is for the scoreboard: $biss_value, $biss_compare.
module biss_encoder #(
    parameter NAME = "encoder",
    parameter SETTINGS = "format=pos26,nE,nW,crc6"
) (
    input  wire ma,
    output reg  slo
);
  initial $biss_encoder(NAME, SETTINGS, ma, slo);
endmodule

// Reads the encoder that drives SLO, while `request` is 1. `latches` counts the first rising edges of
// MA, when the encoder takes its position, and `requests` the requests that have ended.
module biss_master #(
    parameter NAME = "master",
    parameter SETTINGS = "format=pos26,nE,nW,crc6"
) (
    output reg        ma,
    input  wire       slo,
    input  wire       request,
    output reg [31:0] latches,
    output reg [31:0] requests
);
  initial $biss_master(NAME, SETTINGS, ma, slo, request, latches, requests);
endmodule
