// Ids of the strings that kernels compare with: FNV-1a 32 as int (docs/adr/0003). A test of the compiler checks them.
#ifndef OSLCL_STRINGS_H
#define OSLCL_STRINGS_H

#define STR_EMPTY (0) // ""
#define STR_GGX (1275600273) // "ggx"
#define STR_BECKMANN (2120936428) // "beckmann"
#define STR_DEFAULT (-1824826402) // "default"
#define STR_SHARP (-1094050489) // "sharp"
#define STR_PHONG (2033587413) // "phong"
#define STR_SMOOTH (24442543) // "smooth"

#endif
