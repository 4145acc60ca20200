// A small BiSS C master for one channel: a position, nE, nW and CRC6. Written to be read.
//
// MA is `clk` divided by 2 * HALF. SLO falls for ACK at any line delay; from this edge on a bit is
// sampled every 2 * HALF clocks, HALF clocks into the bit: that is line-delay compensation. MA runs
// until STOP has been sampled, then rests high. `start` is taken while `ready`, which waits for the
// encoder to release SLO. After a bad frame SLO means nothing: MA rests for RESPONSE_MAX periods,
// which is longer than a whole frame and its timeout.
module biss_master #(
    parameter int POSITION_BITS = 26,
    parameter int HALF = 8,           // clocks in half a period of MA
    parameter int RESPONSE_MAX = 512  // periods of MA until SLO has fallen, and until START
) (
    input  logic                     clk,
    input  logic                     reset,
    input  logic                     start,
    output logic                     ready,
    output logic                     ma,
    input  logic                     slo,
    output logic                     valid,      // for one clock: the outputs below are new
    output logic                     no_answer,  // neither ACK nor START came
    output logic                     crc_ok,
    output logic                     error,      // nE was 0
    output logic                     warning,    // nW was 0
    output logic [POSITION_BITS-1:0] position
);
  localparam int DATA_BITS = POSITION_BITS + 2;
  localparam int FRAME_BITS = DATA_BITS + 6;
  localparam int DIVIDER_BITS = $clog2(2 * HALF);
  localparam int COUNT_BITS = $clog2(RESPONSE_MAX + 1);
  localparam logic [DIVIDER_BITS-1:0] MIDDLE = DIVIDER_BITS'(HALF - 1);
  localparam logic [DIVIDER_BITS-1:0] LAST = DIVIDER_BITS'(2 * HALF - 1);

  typedef enum logic [2:0] {IDLE, ACK, START, CDS, DATA, STOP, TIMEOUT} state_t;
  state_t state;

  // SLO comes from another clock: two flip-flops before its use.
  logic slo_first, slo_now, slo_before;
  always_ff @(posedge clk) {slo_before, slo_now, slo_first} <= {slo_now, slo_first, slo};

  // MA: low for the first half of each period.
  logic [DIVIDER_BITS-1:0] divider;
  wire running = state != IDLE && state != TIMEOUT;
  always_ff @(posedge clk) begin
    if (reset || !running) begin
      divider <= '0;
      ma <= 1'b1;
    end else begin
      divider <= divider == LAST ? '0 : divider + 1'b1;
      ma <= divider > MIDDLE;
    end
  end

  // Bits: counted again from the falling edge of SLO, so that they are sampled in their middle.
  logic [DIVIDER_BITS-1:0] bit_phase;
  wire ack_falls = state == ACK && slo_before && !slo_now;
  always_ff @(posedge clk) begin
    if (ack_falls || bit_phase == LAST) bit_phase <= '0;
    else bit_phase <= bit_phase + 1'b1;
  end
  wire sample = bit_phase == MIDDLE;

  logic [FRAME_BITS-1:0] frame;
  logic [5:0] crc;
  logic [COUNT_BITS-1:0] count;

  // x^6 + x + 1, most significant bit first. The remainder over the data and the CRC before its
  // inversion is 0.
  function automatic logic [5:0] crc_of(input logic [5:0] old, input logic data);
    crc_of = {old[4:0], 1'b0} ^ (old[5] ^ data ? 6'h03 : 6'h00);
  endfunction
  wire in_data = count < COUNT_BITS'(DATA_BITS);

  assign ready = state == IDLE && slo_now;
  assign position = frame[FRAME_BITS-1-:POSITION_BITS];
  assign error = !frame[7];
  assign warning = !frame[6];
  assign crc_ok = crc == '0;

  always_ff @(posedge clk) begin
    valid <= 1'b0;
    if (reset) begin
      state <= IDLE;
      no_answer <= 1'b0;
    end else begin
      case (state)
        IDLE:
        if (start && ready) begin
          state <= ACK;
          count <= '0;
          crc <= '0;
          no_answer <= 1'b0;
        end
        ACK:
        if (ack_falls) begin
          state <= START;
          count <= '0;
        end else if (divider == LAST) begin
          count <= count + 1'b1;
        end
        START:
        if (sample) begin
          state <= slo_now ? CDS : START;
          count <= count + 1'b1;
        end
        CDS:
        if (sample) begin
          state <= DATA;
          count <= '0;
        end
        DATA:
        if (sample) begin
          frame <= {frame[FRAME_BITS-2:0], slo_now};
          crc <= crc_of(crc, in_data ? slo_now : !slo_now);
          count <= count + 1'b1;
          if (count == COUNT_BITS'(FRAME_BITS - 1)) state <= STOP;
        end
        STOP:
        if (sample) begin
          state <= TIMEOUT;
          valid <= 1'b1;
          count <= '0;
        end
        TIMEOUT: begin
          if (sample && count != COUNT_BITS'(RESPONSE_MAX)) count <= count + 1'b1;
          if (slo_now && (!no_answer && crc_ok || count == COUNT_BITS'(RESPONSE_MAX))) begin
            state <= IDLE;
          end
        end
        default: state <= IDLE;
      endcase
      if ((state == ACK || state == START) && count == COUNT_BITS'(RESPONSE_MAX)) begin
        state <= TIMEOUT;
        valid <= 1'b1;
        no_answer <= 1'b1;
        count <= '0;
      end
    end
  end
endmodule
