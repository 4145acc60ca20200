// What the test benches of biss_line_master try. MA is 5 MHz: the line delays are around whole and
// half periods of 200 ns.
`define MASTER_SETTINGS { \
    "format=pos26,nE,nW,crc6;cds0 timeout=adaptive jitter=20ns ", \
    "positions=0,max,0x2AAAAAA,0x1555555,walk,random,1 ", \
    "flags=none,nE,nW,both,none ", \
    "line_delay=0,45ns,95ns,105ns,150ns,195ns,205ns,295ns,305ns,450ns,1.3us ", \
    "processing=0,250ns,3us ", \
    "faults=none,none,flip,none,none,none,no_answer,none,early_ack,none,none,slo_low,none,", \
    "none,cds_high,none,none,none,stop_high"}
