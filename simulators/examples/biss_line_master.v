// A BiSS C master for one channel, in Verilog: a position, nE, nW and CRC6. It measures the line
// delay of each request, and names the cause of a bad frame as `biss decode` does.
//
// MA is `clk` divided by 2 * HALF. SLO falls for ACK at any line delay. From this edge on, a bit is
// sampled each 2 * HALF clocks, HALF clocks into the bit. MA runs until STOP is sampled. `start` is
// taken while `ready`, which waits until the encoder releases SLO. After a bad frame SLO means
// nothing: MA is high for a whole frame and the longest timeout, so that the encoder is idle.
`timescale 1ps / 1ps

module biss_line_master #(
    parameter POSITION_BITS = 26,
    parameter HALF = 8,            // clocks in half a period of MA
    parameter ANSWER_MAX = 256,    // periods of MA until SLO has fallen
    parameter ACK_MAX = 256,       // periods of MA until START
    // Clocks for which MA is high after a bad frame: the longest frame, and 40 us.
    parameter RESET = 2 * HALF * (ACK_MAX + POSITION_BITS + 12) + 3200
) (
    input  wire                     clk,
    input  wire                     reset,
    input  wire                     start,
    output wire                     ready,
    output reg                      ma,
    input  wire                     slo,
    output reg                      valid,  // for one clock: the outputs below are new
    output reg  [              2:0] cause,
    output wire [POSITION_BITS-1:0] position,
    output wire                     nE,
    output wire                     nW
);
  localparam OK = 0, NO_RESPONSE = 1, RESPONSE_RANGE = 2, NO_START = 3, CDS_HIGH = 4, CRC_WRONG = 5,
      STOP_HIGH = 6;
  localparam DATA_BITS = POSITION_BITS + 2;
  localparam FRAME_BITS = DATA_BITS + 6;
  localparam MIDDLE = HALF - 1;
  localparam LAST = 2 * HALF - 1;

  localparam IDLE = 0, ANSWER = 1, ACK = 2, CDS = 3, DATA = 4, STOP = 5, RELEASE = 6;
  reg [2:0] state;

  // SLO comes from another clock: two flip-flops first.
  reg slo_first, slo_now, slo_before;
  always @(posedge clk) {slo_before, slo_now, slo_first} <= {slo_now, slo_first, slo};

  // MA: low for the first half of each period.
  reg [15:0] divider;
  reg [15:0] clocks;  // rising edges of MA
  wire running = state != IDLE && state != RELEASE;
  always @(posedge clk) begin
    if (reset || !running) begin
      divider <= 0;
      clocks <= 0;
      ma <= 1'b1;
    end else begin
      divider <= divider == LAST ? 16'd0 : divider + 16'd1;
      ma <= divider > MIDDLE;
      if (divider == HALF) clocks <= clocks + 16'd1;
    end
  end

  // Bits: counted again from the falling edge of SLO, so that they are sampled in their middle.
  wire ack_falls = state == ANSWER && slo_before && !slo_now;
  reg [15:0] phase;
  always @(posedge clk) begin
    if (ack_falls || phase == LAST) phase <= 0;
    else phase <= phase + 16'd1;
  end
  wire sample = phase == MIDDLE;

  // x^6 + x + 1, most significant bit first; on the line the CRC is inverted.
  reg [FRAME_BITS-1:0] frame;
  reg [5:0] crc;
  reg [31:0] count;
  wire in_data = count < DATA_BITS;
  wire crc_in = in_data ? slo_now : !slo_now;
  wire [5:0] crc_next = {crc[4:0], 1'b0} ^ (crc[5] ^ crc_in ? 6'h03 : 6'h00);

  assign ready = state == IDLE;
  assign position = frame[FRAME_BITS-1-:POSITION_BITS];
  assign nE = frame[7];
  assign nW = frame[6];

  task finish(input [2:0] reason);
    begin
      state <= RELEASE;
      cause <= reason;
      valid <= 1'b1;
    end
  endtask

  always @(posedge clk) begin
    valid <= 1'b0;
    if (reset) begin
      state <= IDLE;
      cause <= OK;
    end else begin
      case (state)
        IDLE:
        if (start && ready) begin
          state <= ANSWER;
          cause <= OK;
          crc <= 0;
        end
        ANSWER:
        if (ack_falls) begin
          state <= ACK;
          count <= 0;
          // The second rising edge of MA makes SLO fall.
          if (clocks < 2) finish(RESPONSE_RANGE);
        end else if (clocks == ANSWER_MAX) begin
          finish(NO_RESPONSE);
        end
        ACK:
        if (sample) begin
          count <= count + 1;
          if (slo_now) state <= CDS;
          else if (count == ACK_MAX) finish(NO_START);
        end
        CDS:
        if (sample) begin
          state <= DATA;
          count <= 0;
          if (slo_now) cause <= CDS_HIGH;
        end
        DATA:
        if (sample) begin
          frame <= {frame[FRAME_BITS-2:0], slo_now};
          crc <= crc_next;
          count <= count + 1;
          if (count == FRAME_BITS - 1) state <= STOP;
        end
        STOP:
        if (sample) begin
          if (cause == CDS_HIGH) finish(CDS_HIGH);
          else if (crc != 0) finish(CRC_WRONG);
          else if (slo_now) finish(STOP_HIGH);
          else finish(OK);
        end
        RELEASE: begin
          count <= valid ? 1 : count + 1;
          if (!valid && slo_now && (cause == OK || count >= RESET)) state <= IDLE;
        end
        default: state <= IDLE;
      endcase
    end
  end
endmodule
