-- A BiSS C encoder for one channel, in VHDL: a position, nE, nW and CRC6, with a fixed timeout.
--
-- MA comes through two flip-flops, so SLO follows it by three clocks of `clk`. The position is taken
-- at LAT, the first rising edge of MA; processing it takes PROCESSING clocks, in which SLO is low
-- (ACK). VHDL-2008.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;

entity biss_line_slave is
  generic (
    POSITION_BITS : positive := 26;
    PROCESSING    : natural  := 150;
    TIMEOUT       : positive := 1500  -- clocks of clk after the last edge of MA
  );
  port (
    clk      : in  std_logic;
    reset    : in  std_logic;
    ma       : in  std_logic;
    slo      : out std_logic := '1';
    position : in  std_logic_vector(POSITION_BITS - 1 downto 0);
    nE       : in  std_logic;
    nW       : in  std_logic
  );
end entity;

architecture rtl of biss_line_slave is
  constant DATA_BITS : positive := POSITION_BITS + 2;

  type state_t is (IDLE, LAT, ACK, START, CDS, DATA, CRC, HELD);
  signal state      : state_t := IDLE;
  signal ma_first   : std_logic := '1';
  signal ma_now     : std_logic := '1';
  signal ma_before  : std_logic := '1';
  signal taken      : std_logic_vector(DATA_BITS - 1 downto 0) := (others => '0');
  signal processed  : std_logic_vector(DATA_BITS - 1 downto 0) := (others => '0');
  signal shift      : std_logic_vector(DATA_BITS - 1 downto 0) := (others => '0');
  signal checksum   : std_logic_vector(5 downto 0) := (others => '0');
  signal busy       : natural range 0 to PROCESSING := 0;
  signal sent       : natural range 0 to DATA_BITS := 0;
  signal still      : natural range 0 to TIMEOUT := 0;

  -- x^6 + x + 1, most significant bit first.
  function crc_of(old : std_logic_vector(5 downto 0); bit_in : std_logic)
    return std_logic_vector is
    variable shifted : std_logic_vector(5 downto 0);
  begin
    shifted := old(4 downto 0) & '0';
    if (old(5) xor bit_in) = '1' then shifted := shifted xor "000011"; end if;
    return shifted;
  end function;
begin
  process (clk)
    variable rises, falls : boolean;
  begin
    if rising_edge(clk) then
      ma_first  <= ma;
      ma_now    <= ma_first;
      ma_before <= ma_now;
      rises := ma_now = '1' and ma_before = '0';
      falls := ma_now = '0' and ma_before = '1';

      if busy > 0 then
        busy <= busy - 1;
        if busy = 1 then processed <= taken; end if;
      end if;

      case state is
        when IDLE =>
          slo <= '1';
          if falls then state <= LAT; end if;
        when LAT =>
          if rises then
            taken <= position & nE & nW;
            busy  <= PROCESSING;
            state <= ACK;
          end if;
        when ACK =>
          if rises then
            slo   <= '0';
            state <= START;
          end if;
        when START =>
          if rises and busy = 0 then
            slo   <= '1';
            shift <= processed;
            state <= CDS;
          end if;
        when CDS =>
          if rises then
            slo      <= '0';
            sent     <= 0;
            checksum <= (others => '0');
            state    <= DATA;
          end if;
        when DATA =>
          if rises then
            slo      <= shift(DATA_BITS - 1);
            checksum <= crc_of(checksum, shift(DATA_BITS - 1));
            shift    <= shift(DATA_BITS - 2 downto 0) & '0';
            sent     <= sent + 1;
            if sent = DATA_BITS - 1 then
              sent  <= 0;
              state <= CRC;
            end if;
          end if;
        when CRC =>
          if rises then
            slo      <= not checksum(5);
            checksum <= checksum(4 downto 0) & '0';
            sent     <= sent + 1;
            if sent = 6 then
              slo   <= '0';
              state <= HELD;
            end if;
          end if;
        when HELD => null;
      end case;

      -- An idle MA ends a request, at any place in the frame.
      if rises or falls then
        still <= 0;
      elsif still < TIMEOUT then
        still <= still + 1;
      else
        state <= IDLE;
        slo   <= '1';
      end if;
      if reset = '1' then state <= IDLE; end if;
    end if;
  end process;
end architecture;
