"""A text file in C: python3 embed.py OUT_C OUT_H NAME TEXT makes an array of characters of it."""
import pathlib
import sys

out_c, out_h, name, text = sys.argv[1:]
data = pathlib.Path(text).read_bytes() + b'\0'
lines = (','.join(str(b if b < 128 else b - 256) for b in data[at:at + 24]) for at in range(0, len(data), 24))
pathlib.Path(out_h).write_text(f'extern const char {name}[{len(data)}];\n')
pathlib.Path(out_c).write_text(f'#include "{name}.h"\nconst char {name}[] = {{\n' + ',\n'.join(lines) + ',\n};\n')
