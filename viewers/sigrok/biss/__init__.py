'''
BiSS C is a serial interface for position encoders. The master sends the clock on MA, the encoder
answers on SLO: ACK while it processes the position, then START, CDS, the position, an error and a
warning bit, a CRC, and STOP.

This decoder shows the fields of every frame, its position or the one cause why there is none, the
register accesses in CDM and CDS, and the verdict on encoders of BiSS Safety. It needs the Python
module biss, whose command `biss decode` gives the same rows.
'''

from .pd import Decoder
