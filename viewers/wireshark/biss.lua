-- Wireshark: the fields of a row of `biss decode --to jsonl`, a packet each.
--
-- The link type is USER0 (147), the packet is the row as text. Fields have the names of the columns
-- with `biss.` before them: biss.position, biss.nE, biss.crc2_ok. `biss.cause` is the status of a
-- row that has no position because of a failure.

local biss = Proto("biss", "BiSS C request cycle")

local channels_max = 8
local row_bytes_max = 65535

local flag_texts = {
  nE = { [0] = "the encoder reports an error", [1] = "no error" },
  nW = { [0] = "the encoder reports a warning", [1] = "no warning" },
  crc = { [0] = "wrong", [1] = "right" },
  marginal = { [0] = "no", [1] = "SLO changes close to a sampling point" },
}

-- What is said of a status that is not `ok`; the page docs/status.md explains each.
local status_texts = {
  no_response = "SLO stayed high through the whole request",
  not_ready = "SLO was low when the request began",
  response_range = "SLO fell before the edge of MA that makes ACK, or much later",
  no_start = "ACK came, and SLO stayed low until MA stopped",
  ack_range = "START came earlier or later than the encoder's bounds allow",
  truncated = "MA stopped before the last CRC bit of the format",
  cds = "CDS was 1, and the format says that it must be 0",
  crc = "the checksum of a channel is wrong",
  stop_bit = "the bit after the last one is not 0",
  cut_start = "the capture begins inside this cycle",
  cut_end = "the capture ends inside this cycle",
  ma_glitch = "a pulse on MA and not a request",
  ma_clock = "an edge of MA is missing, or there is one too many",
  unknown_level = "MA or SLO was neither 0 nor 1 where it mattered",
  unchecked = "the format is not known, so that nothing else can be checked",
}
local incomplete = { cut_start = true, cut_end = true, unchecked = true }
-- States of the safety monitor; every other verdict is a fault.
local safety_states = { safe = true, starting = true, latched = true, failed = true }

-- Column name -> { field = ProtoField, read = function(text) -> value or nil }
local columns = {}

-- A decimal number as two halves of 32 bits; nil where it has more than 64.
local function halves_of(digits)
  local low, high = 0, 0
  if not digits:match("^%d+$") then return nil end
  for digit in digits:gmatch("%d") do
    low = low * 10 + tonumber(digit)
    local carry = math.floor(low / 4294967296)
    low = low - carry * 4294967296
    high = high * 10 + carry
    if high >= 4294967296 then return nil end
  end
  return low, high
end

local function read_unsigned(text)
  local low, high = halves_of(text)
  return low and UInt64.new(low, high)
end
local function read_signed(text)
  local sign, digits = text:match("^(%-?)(%d+)$")
  local low, high = halves_of(digits or "")
  if not low or high >= 2147483648 then return nil end
  local value = Int64.new(low, high)
  return sign == "-" and -value or value
end
local function read_flag(text) return (text == "0" or text == "1") and tonumber(text) or nil end
local function read_text(text) return text end

local fields = {}
local function column(name, field, read)
  columns[name] = { field = field, read = read }
  fields[#fields + 1] = field
end
local function unsigned(name, title)
  column(name, ProtoField.uint64("biss." .. name, title, base.DEC), read_unsigned)
end
local function real(name, title)
  column(name, ProtoField.double("biss." .. name, title), tonumber)
end
local function flag(name, title, texts)
  column(name, ProtoField.uint8("biss." .. name, title, base.DEC, texts), read_flag)
end
local function text(name, title)
  column(name, ProtoField.string("biss." .. name, title), read_text)
end

unsigned("cycle", "Cycle")
real("time_ns", "Time (ns)")
text("status", "Status")
real("line_delay_ns", "Line delay (ns)")
real("ack_ns", "ACK (ns)")
unsigned("clock_hz", "Clock (Hz)")
text("raw", "Raw, START to STOP")
for k = 1, channels_max do
  local number = k == 1 and "" or tostring(k)
  local of = k == 1 and "" or " of channel " .. k
  unsigned("position" .. number, "Position" .. of)
  flag("nE" .. number, "nE" .. of, flag_texts.nE)
  flag("nW" .. number, "nW" .. of, flag_texts.nW)
  flag("crc" .. number .. "_ok", "CRC" .. of, flag_texts.crc)
  unsigned("lc" .. number, "Sign of life" .. of)
  unsigned("mt" .. number, "Multiturn" .. of)
  unsigned("st" .. number, "Singleturn" .. of)
end
flag("marginal", "Marginal", flag_texts.marginal)
text("safety", "Safety verdict")
text("limits", "Limits exceeded")
column("unwrapped", ProtoField.int64("biss.unwrapped", "Unwrapped position", base.DEC), read_signed)
for _, unit in ipairs({ "deg", "mm" }) do
  real("position_" .. unit, "Position (" .. unit .. ")")
end
for _, unit in ipairs({ "counts", "deg", "mm" }) do
  real("velocity_" .. unit .. "_s", "Velocity (" .. unit .. "/s)")
end
text("file", "Capture")
text("ma", "Line MA")
text("slo", "Line SLO")

local cause = ProtoField.string("biss.cause", "Cause")
local other = ProtoField.string("biss.other", "Other column")
fields[#fields + 1] = cause
fields[#fields + 1] = other
biss.fields = fields

local function note(name, title, group, severity)
  return ProtoExpert.new("biss." .. name, title, group, severity)
end
local failure = note("failure", "Failure of the transmission", expert.group.PROTOCOL,
                     expert.severity.ERROR)
local cut = note("incomplete", "Cycle not checked", expert.group.PROTOCOL, expert.severity.NOTE)
local error_bit = note("error", "The encoder reports an error", expert.group.RESPONSE_CODE,
                       expert.severity.ERROR)
local warning_bit = note("warning", "The encoder reports a warning", expert.group.RESPONSE_CODE,
                         expert.severity.WARN)
local safety_fault = note("safety_fault", "Fault of BiSS Safety", expert.group.SECURITY,
                          expert.severity.ERROR)
local limit = note("limit", "Limit of the encoder exceeded", expert.group.PROTOCOL,
                   expert.severity.WARN)
local marginal = note("margin", "SLO changes close to a sampling point", expert.group.PROTOCOL,
                      expert.severity.NOTE)
local malformed = note("malformed", "Not a row of biss decode --to jsonl", expert.group.MALFORMED,
                       expert.severity.ERROR)
biss.experts = { failure, cut, error_bit, warning_bit, safety_fault, limit, marginal, malformed }

-- The end of the string whose first character is at `at`: where its closing quote is, or nil.
local function string_end(line, at)
  while true do
    local found = line:find('["\\]', at)
    if not found or line:byte(found) == 34 then return found end
    at = found + 2
  end
end

local escapes = { n = "\n", t = "\t", r = "\r", b = "\b", f = "\f" }
local function unescaped(text)
  return (text:gsub("\\([^u])", function(c) return escapes[c] or c end))
end

-- The value at `at`: its text (nil for null), where it begins and ends; nothing where it is none.
local function value_at(line, at)
  if line:byte(at) == 34 then
    local close = string_end(line, at + 1)
    if not close then return end
    return true, unescaped(line:sub(at + 1, close - 1)), at, close
  end
  local first, last = line:find("^%-?%d[%d.eE+-]*", at)
  if first then return true, line:sub(first, last), first, last end
  if line:sub(at, at + 3) == "null" then return true, nil, at, at + 3 end
end

-- Calls take(name, text, first, last) for each value of a row that is not null.
-- Returns whether the row is whole.
local function each_value(line, take)
  local at = line:match("^%s*{%s*()")
  if not at then return false end
  while true do
    local name, value = line:match('^"([%w_]+)"%s*:%s*()', at)
    if not name then return false end
    local known, text, first, last = value_at(line, value)
    if not known then return false end
    if text then take(name, text, first, last) end
    local sign, rest = line:match("^%s*([,}])%s*()", last + 1)
    if not sign then return false end
    if sign == "}" then return rest > #line end
    at = rest
  end
end

local function judge_status(status, tree)
  if status == "ok" or status == nil then return end
  local words = status .. ": " .. (status_texts[status] or "see docs/status.md")
  if status ~= "unchecked" then tree:add(cause, status):set_generated() end
  tree:add_proto_expert_info(incomplete[status] and cut or failure, words)
end

local function judge_flags(row, tree)
  for k = 1, channels_max do
    local number = k == 1 and "" or tostring(k)
    if row["nE" .. number] == "0" then
      tree:add_proto_expert_info(error_bit, "nE" .. number .. " = 0: do not use the position")
    end
    if row["nW" .. number] == "0" then
      tree:add_proto_expert_info(warning_bit, "nW" .. number .. " = 0")
    end
  end
end

local function judge(row, tree)
  judge_status(row.status, tree)
  judge_flags(row, tree)
  if row.safety and not safety_states[row.safety] then
    tree:add_proto_expert_info(safety_fault, "safety: " .. row.safety)
  end
  if row.limits then tree:add_proto_expert_info(limit, "limits: " .. row.limits) end
  if row.marginal == "1" then tree:add_proto_expert_info(marginal) end
end

local function info_of(row)
  local words = { row.status or "" }
  for k = 1, channels_max do
    local number = k == 1 and "" or tostring(k)
    local position = row["position" .. number]
    if position then words[#words + 1] = "position" .. number .. " " .. position end
    for _, name in ipairs({ "nE" .. number, "nW" .. number }) do
      if row[name] == "0" then words[#words + 1] = name .. "=0" end
    end
  end
  if row.safety then words[#words + 1] = row.safety end
  if row.limits then words[#words + 1] = row.limits end
  return table.concat(words, "  ")
end

function biss.dissector(buffer, packet, root)
  local length = math.min(buffer:len(), row_bytes_max)
  local tree = root:add(biss, buffer())
  packet.cols.protocol = "BiSS C"
  local line = length > 0 and buffer:raw(0, length) or ""
  local row = {}
  local whole = each_value(line, function(name, text, first, last)
    local range = buffer(first - 1, last - first + 1)
    local known = columns[name]
    local value = known and known.read(text)
    if value ~= nil then
      tree:add(known.field, range, value)
      row[name] = text
    else
      tree:add(other, range, name .. ": " .. text)
    end
  end)
  if not whole then
    tree:add_proto_expert_info(malformed)
    packet.cols.info = "not a row of biss decode --to jsonl"
    return buffer:len()
  end
  if row.cycle then tree:append_text(" " .. row.cycle) end
  packet.cols.info = info_of(row)
  judge(row, tree)
  return buffer:len()
end

DissectorTable.get("wtap_encap"):add(wtap.USER0, biss)
