"""one_object.py OUT ARCHIVE... -- OBJCOPY CC...: one object of whole archives, in which what is hidden is local."""
import subprocess
import sys

out, *archives = sys.argv[1:sys.argv.index("--")]
objcopy, *cc = sys.argv[sys.argv.index("--") + 1:]
subprocess.run([*cc, "-r", "-nostdlib", "-o", out, "-Wl,--whole-archive", *archives, "-Wl,--no-whole-archive"], check=True)
subprocess.run([objcopy, "--localize-hidden", out], check=True)
