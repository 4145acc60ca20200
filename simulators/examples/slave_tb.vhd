-- Our master reads biss_line_slave in GHDL, and the scoreboard compares what it reads.
library ieee;
use ieee.std_logic_1164.all;
use ieee.numeric_std.all;
use std.env.all;
use work.biss_pkg.all;

entity slave_tb is
  generic (
    REQUESTS_MAX  : positive := 60;
    POSITION_BITS : positive := 26
  );
end entity;

architecture bench of slave_tb is
  -- Clocks, line delays and CDM in turn. The timeout is 15 us after the last edge.
  constant SETTINGS : string :=
    "format=pos26,nE,nW,crc6;cds0 timeout=15.2us jitter=10ns clock=1MHz,5MHz,80kHz,2MHz,4MHz" &
    " line_delay=0,200ns,1us,270ns,2.2us,20us,1.3us pause=0,3us cdm=0,1,0";

  signal clk, reset, request : std_logic := '0';
  signal ma, slo, nE, nW     : std_logic := '1';
  signal latches, requests   : natural;
  signal position            : std_logic_vector(POSITION_BITS - 1 downto 0) := (others => '0');
  signal done                : boolean := false;
begin
  clk <= not clk after 5 ns when not done;

  encoder : entity work.biss_line_slave
    generic map (POSITION_BITS => POSITION_BITS)
    port map (clk => clk, reset => reset, ma => ma, slo => slo, position => position, nE => nE,
              nW => nW);

  master : entity work.biss_master
    generic map (NAME => "drive", SETTINGS => SETTINGS)
    port map (ma => ma, slo => slo, request => request, latches => latches,
              requests => requests);

  -- The shaft does not move until LAT has passed the flip-flops of the encoder, then it moves on.
  sent : process
    variable turn : natural := 0;
  begin
    wait on latches;
    biss_value("drive", 0, position, nE, nW);
    biss_compare("drive", "ok");
    wait for 100 ns;
    turn := turn + 1;
    case turn mod 5 is
      when 0 => position <= (others => '0');
      when 1 => position <= (others => '1');
      when others =>
        position <= std_logic_vector(unsigned(position(POSITION_BITS - 10 downto 0) & "101100101")
                                     + turn);
    end case;
    nE <= '0' when turn mod 4 = 1 or turn mod 4 = 3 else '1';
    nW <= '0' when turn mod 4 = 2 or turn mod 4 = 3 else '1';
  end process;

  run : process
    variable before : natural;
  begin
    request <= '1';
    -- An encoder that never releases SLO is not waited for.
    while requests < REQUESTS_MAX loop
      before := requests;
      wait on requests for 2 ms;
      exit when requests = before;
    end loop;
    if biss_report("slave_tb") = 0 then
      report "slave_tb: passed";
      done <= true;
      finish;
    end if;
    report "slave_tb: failed";
    stop(1);  -- the exit status
  end process;
end architecture;
