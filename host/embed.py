"""A text file as a C array: python3 embed.py TEXT OUT_C OUT_H NAME"""
import sys

text, out_c, out_h, name = sys.argv[1:5]
with open(text, 'rb') as file:
    data = file.read() + b'\0'
with open(out_h, 'w') as file:
    file.write(f'extern const char {name}[{len(data)}];\n')
with open(out_c, 'w') as file:
    file.write(f'#include "{name}.h"\nconst char {name}[] = {{\n')
    for at in range(0, len(data), 24):
        file.write(','.join(str(b if b < 128 else b - 256) for b in data[at:at + 24]) + ',\n')
    file.write('};\n')
