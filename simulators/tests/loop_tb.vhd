-- Our master reads our encoder in GHDL: positions that the bench gives go around.
library ieee;
use ieee.std_logic_1164.all;
use std.env.all;
use work.biss_pkg.all;

entity loop_tb is
end entity;

architecture bench of loop_tb is
  signal ma, slo           : std_logic;
  signal request           : std_logic := '0';
  signal latches, requests : natural;
  signal position          : std_logic_vector(35 downto 0) := x"123456789";
begin
  encoder : entity work.biss_encoder
    generic map (
      NAME     => "sender",
      SETTINGS => "format=pos36,nE,nW,crc6 processing=0,5us timeout=20us")
    port map (ma => ma, slo => slo);
  master : entity work.biss_master
    generic map (
      NAME     => "reader",
      SETTINGS => "format=pos36,nE,nW,crc6 clock=1MHz,10MHz,80kHz timeout=20us" &
                  " line_delay=0,150ns,3us,0 cdm=0,0,0,1,1")
    port map (ma => ma, slo => slo, request => request, latches => latches,
              requests => requests);

  process
  begin
    wait on latches;
    biss_value("reader", 0, position, position(0), position(1));
    biss_compare("reader", "ok");
  end process;

  process
  begin
    wait for 1 us;
    for k in 1 to 30 loop
      biss_next("sender", 0, position, position(0), position(1));
      request <= '1';
      wait on requests;
      request <= '0';
      biss_value("sender", 0, position, position(0), position(1));
      biss_compare("sender", "ok");
      position <= position(34 downto 0) & (position(35) xor position(24));
      wait for 5 us;
    end loop;
    if biss_report("loop_tb") = 0 then
      report "loop_tb: passed";
      finish;
    end if;
    report "loop_tb: failed";
    stop(1);
  end process;
end architecture;
