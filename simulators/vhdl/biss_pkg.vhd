-- Encoders, masters and scoreboards of biss for GHDL, by VHPIDIRECT: an encoder or a master is an
-- instance of the entities below. The loader has to find libbiss_testbench.so (LD_LIBRARY_PATH).
-- VHDL-2008. docs/simulators.md describes the settings.
library ieee;
use ieee.std_logic_1164.all;

package biss_pkg is
  -- The scoreboard of the instance `name`. For an encoder: the values that the design has read. For
  -- a master: the values that the design was given at LAT. biss_value for each channel, then
  -- biss_compare.
  procedure biss_value(name : string; channel : natural; position : std_logic_vector;
                       nE, nW : std_logic);
  -- `cause` as in `biss decode`: "ok", "crc", "no_response"; "fault" if the design names none.
  procedure biss_compare(name : string; cause : string);
  attribute foreign of biss_compare : procedure is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_compare";
  -- The next frame of an encoder.
  procedure biss_next(name : string; channel : natural; position : std_logic_vector;
                      nE, nW : std_logic);
  -- Writes path.txt and path.json, prints the report. Returns the number of mismatches.
  impure function biss_report(path : string) return integer;
  attribute foreign of biss_report : function is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_report";

  -- For the entities below.
  subtype biss_bits is std_logic_vector(63 downto 0);

  impure function biss_open_encoder(name, settings : string) return integer;
  attribute foreign of biss_open_encoder : function is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_encoder";
  impure function biss_open_master(name, settings : string) return integer;
  attribute foreign of biss_open_master : function is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_master";
  impure function biss_step_encoder(id : integer; at : time; ma : integer) return time;
  attribute foreign of biss_step_encoder : function is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_step_encoder";
  impure function biss_step_master(id : integer; at : time; slo, request : integer) return time;
  attribute foreign of biss_step_master : function is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_step_master";
  impure function biss_level(id : integer) return integer;
  attribute foreign of biss_level : function is "VHPIDIRECT libbiss_testbench.so biss_tb_level";
  impure function biss_latches(id : integer) return integer;
  attribute foreign of biss_latches : function is
    "VHPIDIRECT libbiss_testbench.so biss_tb_latches";
  impure function biss_requests(id : integer) return integer;
  attribute foreign of biss_requests : function is
    "VHPIDIRECT libbiss_testbench.so biss_tb_requests";
  procedure biss_put_value(name : string; channel : integer; position : biss_bits;
                           nE, nW, is_next : integer);
  attribute foreign of biss_put_value : procedure is
    "VHPIDIRECT libbiss_testbench.so biss_ghdl_value";

  -- 0 for '0' and 'L', 1 for every other level: a line that nothing drives is high.
  function biss_line(level : std_logic) return integer;
  -- '0' or '1'.
  function biss_logic(level : integer) return std_logic;
end package;

package body biss_pkg is
  function biss_line(level : std_logic) return integer is
  begin
    if to_x01(level) = '0' then return 0; end if;
    return 1;
  end function;

  function biss_logic(level : integer) return std_logic is
  begin
    if level = 0 then return '0'; end if;
    return '1';
  end function;

  -- -1 for a level that is neither 0 nor 1.
  function flag(level : std_logic) return integer is
  begin
    case to_x01(level) is
      when '0' => return 0;
      when '1' => return 1;
      when others => return -1;
    end case;
  end function;

  function widened(position : std_logic_vector) return biss_bits is
    variable bits : biss_bits := (others => '0');
  begin
    bits(position'length - 1 downto 0) := position;
    return bits;
  end function;

  procedure biss_value(name : string; channel : natural; position : std_logic_vector;
                       nE, nW : std_logic) is
  begin
    biss_put_value(name, channel, widened(position), flag(nE), flag(nW), 0);
  end procedure;

  procedure biss_next(name : string; channel : natural; position : std_logic_vector;
                      nE, nW : std_logic) is
  begin
    biss_put_value(name, channel, widened(position), flag(nE), flag(nW), 1);
  end procedure;

  -- The bodies of foreign functions are never run.
  impure function biss_open_encoder(name, settings : string) return integer is
  begin report "foreign" severity failure; return 0; end function;
  impure function biss_open_master(name, settings : string) return integer is
  begin report "foreign" severity failure; return 0; end function;
  impure function biss_step_encoder(id : integer; at : time; ma : integer) return time is
  begin report "foreign" severity failure; return 0 fs; end function;
  impure function biss_step_master(id : integer; at : time; slo, request : integer) return time is
  begin report "foreign" severity failure; return 0 fs; end function;
  impure function biss_level(id : integer) return integer is
  begin report "foreign" severity failure; return 0; end function;
  impure function biss_latches(id : integer) return integer is
  begin report "foreign" severity failure; return 0; end function;
  impure function biss_requests(id : integer) return integer is
  begin report "foreign" severity failure; return 0; end function;
  procedure biss_put_value(name : string; channel : integer; position : biss_bits;
                           nE, nW, is_next : integer) is
  begin report "foreign" severity failure; end procedure;
  procedure biss_compare(name : string; cause : string) is
  begin report "foreign" severity failure; end procedure;
  impure function biss_report(path : string) return integer is
  begin report "foreign" severity failure; return 0; end function;
end package body;

-- Answers the master that drives MA.
library ieee;
use ieee.std_logic_1164.all;
use work.biss_pkg.all;

entity biss_encoder is
  generic (
    NAME     : string := "encoder";
    SETTINGS : string := "format=pos26,nE,nW,crc6"
  );
  port (
    ma  : in  std_logic;
    slo : out std_logic := '1'
  );
end entity;

architecture simulated of biss_encoder is
begin
  process
    variable id  : integer;
    variable due : time;
  begin
    id := biss_open_encoder(NAME, SETTINGS);
    assert id /= 0 report "biss_encoder " & NAME severity failure;
    loop
      due := biss_step_encoder(id, now, biss_line(ma));
      slo <= biss_logic(biss_level(id));
      if due = time'high then
        wait on ma;
      else
        wait on ma for due - now;
      end if;
    end loop;
  end process;
end architecture;

-- Reads the encoder that drives SLO, while `request` is '1'. `latches` counts the first rising edges
-- of MA, when the encoder takes its position, and `requests` the requests that have ended.
library ieee;
use ieee.std_logic_1164.all;
use work.biss_pkg.all;

entity biss_master is
  generic (
    NAME     : string := "master";
    SETTINGS : string := "format=pos26,nE,nW,crc6"
  );
  port (
    ma       : out std_logic := '1';
    slo      : in  std_logic;
    request  : in  std_logic;
    latches  : out natural := 0;
    requests : out natural := 0
  );
end entity;

architecture simulated of biss_master is
begin
  process
    variable id  : integer;
    variable due : time;
    variable ask : integer;
  begin
    id := biss_open_master(NAME, SETTINGS);
    assert id /= 0 report "biss_master " & NAME severity failure;
    loop
      ask := 0;
      if to_x01(request) = '1' then ask := 1; end if;
      due := biss_step_master(id, now, biss_line(slo), ask);
      latches  <= biss_latches(id);
      ma       <= biss_logic(biss_level(id));
      requests <= biss_requests(id);
      if due = time'high then
        wait on slo, request;
      else
        wait on slo, request for due - now;
      end if;
    end loop;
  end process;
end architecture;
