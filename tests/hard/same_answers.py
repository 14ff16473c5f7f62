"""Runs random calls on several backends, and compares what they answer, life by life.

  same_answers.py [ARGUMENTS of random_calls] -- PROGRAM BACKEND [PROGRAM BACKEND ...]

Answers are the same for all; pictures for all that draw. Where they are not, the seed is run again, and the first step
is told at which they part. With --minutes the programs get to different seeds, and those that all have got to count.
"""
import re
import subprocess
import sys

LIFE = re.compile(r"seed (\d+): (\d+) calls, answers (\w+), pictures (\w+)")
WITHOUT_PICTURES = "null"


def start(program, backend, arguments):
    return subprocess.Popen([program, backend, *arguments], stdout=subprocess.PIPE, text=True)


def lives(text):
    return {int(seed): (int(calls), answers, pictures) for seed, calls, answers, pictures in LIFE.findall(text)}


def steps(program, backend, arguments, seed):
    again = start(program, backend, [*arguments, "--seed", str(seed), "--lives", "1", "--minutes", "0", "--trace"])
    return [line for line in again.communicate()[0].splitlines() if line[:1].isdigit()]


def seen(backend, line):
    """What of a step must be the same."""
    line = re.sub(r"\b[0-9a-f]+ (still|does not exist)", r"\1", line)  # handles are each context's own
    return line.split(", pictures")[0] if backend == WITHOUT_PICTURES else line[: line.find("pictures") + 25]


def tell_step(sides, arguments, seed):
    (first, first_backend), (second, second_backend) = sides
    plain = WITHOUT_PICTURES if WITHOUT_PICTURES in (first_backend, second_backend) else ""
    before = steps(first, first_backend, arguments, seed)
    for a, b in zip(before, steps(second, second_backend, arguments, seed)):
        if seen(plain, a) != seen(plain, b):
            print(f"  {first_backend}: {a}\n  {second_backend}: {b}")
            return


def compare(sides, found, arguments):
    """Prints the first seed at which two of the sides part; returns how many seeds there were."""
    common = sorted(set.intersection(*(set(lives) for lives in found)))
    for seed in common:
        for index in range(1, len(sides)):
            pictures = WITHOUT_PICTURES not in (sides[0][1], sides[index][1])
            parts = 3 if pictures else 2
            if found[0][seed][:parts] != found[index][seed][:parts]:
                print(f"seed {seed}: {sides[0][1]} and {sides[index][1]} answer differently")
                tell_step((sides[0], sides[index]), arguments, seed)
                sys.exit(1)
    return common


def main():
    split = sys.argv.index("--")
    arguments, names = sys.argv[1:split], sys.argv[split + 1 :]
    sides = list(zip(names[::2], names[1::2]))
    running = [start(program, backend, arguments) for program, backend in sides]
    texts = [process.communicate()[0] for process in running]
    found = [lives(text) for text in texts]
    # Those that draw come first, so that the first has pictures for all others to be compared with.
    common = compare(sides, found, arguments)
    for (_, backend), process, answered in zip(sides, running, found):
        print(f"{backend}: {sum(life[0] for life in answered.values())} calls")
        if process.returncode:
            sys.exit(f"{backend} failed")
    if not common:
        sys.exit("there is nothing to compare")


main()
