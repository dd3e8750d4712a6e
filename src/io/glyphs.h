/* Letters for legends: digits and what units need, 5 x 7 dots. */
#ifndef HPR_IO_GLYPHS_H
#define HPR_IO_GLYPHS_H

enum { HPR_GLYPH_WIDTH = 5, HPR_GLYPH_HEIGHT = 7, HPR_GLYPH_ADVANCE = 6 };

/* The rows of a letter from the top, bit 4 the leftmost dot. Known: 0-9 . - + e W / m and ^ for a raised 2;
 * others are blank. Static, [7]. */
const unsigned char *hpr_glyph(char letter);

#endif
