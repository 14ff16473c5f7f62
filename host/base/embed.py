"""Text files in C: python3 embed.py OUT_C OUT_H NAME TEXT, or --table OUT_C OUT_H NAME TEXT...

The first makes an array of characters of one text; the second a table of any number of texts, each by its file's name
without the ending, and an entry without a name at the end.
"""
import pathlib
import sys


def array(path):
    data = path.read_bytes() + b'\0'
    lines = (','.join(str(b if b < 128 else b - 256) for b in data[at:at + 24]) for at in range(0, len(data), 24))
    return len(data), '{\n' + ',\n'.join(lines) + ',\n}'


def one(name, text):
    size, values = array(text)
    return f'extern const char {name}[{size}];\n', f'const char {name}[] = {values};\n'


def table(name, texts):
    entry = 'struct embedded_text {\n  const char *name, *text;\n};\n'
    arrays = ''.join(f'static const char text_{i}[] = {array(text)[1]};\n' for i, text in enumerate(texts))
    rows = ''.join(f'  {{"{text.stem}", text_{i}}},\n' for i, text in enumerate(texts))
    return (f'{entry}extern const struct embedded_text {name}[{len(texts) + 1}];\n',
            f'{arrays}const struct embedded_text {name}[] = {{\n{rows}  {{0}},\n}};\n')


arguments = sys.argv[1:]
is_table = arguments[0] == '--table'
out_c, out_h, name, *texts = arguments[is_table:]
texts = [pathlib.Path(text) for text in texts]
header, code = table(name, texts) if is_table else one(name, texts[0])
pathlib.Path(out_h).write_text(header)
pathlib.Path(out_c).write_text(f'#include "{name}.h"\n{code}')
