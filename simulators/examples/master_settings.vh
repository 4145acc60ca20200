// The recommended settings for a master: the test benches of biss_line_master use them. MA is 5
// MHz: the line delays are around whole and half periods of 200 ns, the jitter is a quarter of a
// period. Make at least 240 requests.
`define MASTER_SETTINGS { \
    "format=pos26,nE,nW,crc6;cds0 timeout=adaptive jitter=50ns ", \
    "positions=0,max,0x2AAAAAA,0x1555555,walk,random,1 ", \
    "flags=none,nE,nW,both,none ", \
    "line_delay=0,45ns,95ns,105ns,150ns,195ns,205ns,295ns,305ns,450ns,1.3us ", \
    "processing=0,250ns,3us ", \
    "faults=none,flip_crc,none,flip,none,no_answer,none,early_ack,none,flip_crc,none,burst,none,", \
    "slo_low,none,cds_high,none,flip_crc,none,stop_high,none,crc_polarity,none"}
