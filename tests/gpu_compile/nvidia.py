#!/usr/bin/env python3
"""The OpenCL compiler of NVIDIA's driver, which needs no GPU, and what its output says of barriers.

  tests/gpu_compile/nvidia.py LIBRARY SOURCE PTX TARGET [OPTION ...]

LIBRARY: libnvidia-nvvm.so of a driver. TARGET: sm_90 and the like.
"""
import ctypes
import pathlib
import re
import sys


def compiled(library, source, target, options):
    """PTX of OpenCL C; raises RuntimeError with the compiler's words."""
    compiler = ctypes.CDLL(str(library))
    text, log, out = source.encode(), ctypes.c_char_p(), ctypes.c_char_p()
    words = ["-cl-nv-cstd=CL1.2", "-nv-m64", "-cl-nv-arch", target, *(o for o in options if not o.startswith("-cl-") and o != "-w")]
    code = compiler.NvCliCompileProgram((ctypes.c_char_p * 1)(text), ctypes.c_uint(1), (ctypes.c_size_t * 1)(len(text)),
                                        " ".join(words).encode(), ctypes.byref(log), ctypes.byref(out))
    if code != 0 or not out.value:
        raise RuntimeError((log.value or b"no message").decode(errors="replace").strip())
    return out.value.decode()


class Flow:
    """Basic blocks of a PTX function: successors, which of them have a barrier."""

    def __init__(self, body):
        self.labels, self.names, self.barrier, to = {}, [""], [False], [[]]

        def begin(name, falls_in):
            if falls_in:
                to[-1].append(len(to))
            self.names.append(name)
            self.barrier.append(False)
            to.append([])
        ended = False
        for line in map(str.strip, body.splitlines()):
            label = re.match(r"(\$?\w+):", line)
            branch = re.match(r"(@!?%\w+\s+)?bra(?:\.\w+)?\s+(\$?\w+);", line)
            if label:
                begin(label.group(1), not ended)
                self.labels[label.group(1)] = len(to) - 1
                ended = False
            elif branch:
                to[-1].append(branch.group(2))
                begin("", branch.group(1) is not None)
                ended = branch.group(1) is None
            elif re.match(r"(ret|exit);", line):
                begin("", False)
                ended = True
            elif re.match(r"(@!?%\w+\s+)?bar(rier)?\.", line):
                self.barrier[-1] = True
        self.to = [[self.labels[t] if isinstance(t, str) else t for t in targets] for targets in to]
        self.order = self.reached()
        self.of = [[] for _ in self.to]
        for block in self.order:
            for target in self.to[block]:
                self.of[target].append(block)

    def reached(self):
        """Blocks in reverse postorder."""
        out, seen, stack = [], {0}, [(0, iter(self.to[0]))]
        while stack:
            target = next((t for t in stack[-1][1] if t not in seen), None)
            if target is None:
                out.append(stack.pop()[0])
            else:
                seen.add(target)
                stack.append((target, iter(self.to[target])))
        return out[::-1]

    def dominators(self):
        """Immediate ones (Cooper, Harvey and Kennedy 2001)."""
        rank = {block: i for i, block in enumerate(self.order)}
        above, changed = {0: 0}, True
        while changed:
            changed = False
            for block in self.order[1:]:
                best = None
                for a in (p for p in self.of[block] if p in above):
                    b = best if best is not None else a
                    while a != b:
                        a, b = (above[a], b) if rank[a] > rank[b] else (a, above[b])
                    best = a
                changed |= above.get(block) != best
                above[block] = best
        return above

    def shared_heads(self):
        """Labels at which several loops begin, one of them with a barrier: those who leave an inner loop early go through the barrier
        without the rest of their warp, as nothing says where the two loops part."""
        above, tails = self.dominators(), {}
        for block in self.order:
            for head in self.to[block]:
                at = block
                while at not in (head, 0):
                    at = above[at]
                if at == head:
                    tails.setdefault(head, []).append(block)
        return [self.names[head] for head, own in tails.items() if len(own) > 1 and any(self.has_barrier(head, tail) for tail in own)]

    def has_barrier(self, head, tail):
        inside, stack = {head}, [tail]
        while stack:
            block = stack.pop()
            if block not in inside:
                inside.add(block)
                stack += self.of[block]
        return any(self.barrier[block] for block in inside)


def shared_heads(ptx):
    """{kernel: labels} of those that have any."""
    found = {}
    for part in re.sub(r"//.*", "", ptx).split(".entry ")[1:]:
        heads = Flow(part[part.index("{") + 1:]).shared_heads()
        if heads:
            found[re.match(r"\w+", part).group(0)] = heads
    return found


def main():
    if len(sys.argv) < 5:
        sys.exit(__doc__)
    library, source, ptx, target, *options = sys.argv[1:]
    try:
        pathlib.Path(ptx).write_text(compiled(library, pathlib.Path(source).read_text(), target, options))
    except RuntimeError as error:
        sys.exit(str(error))


if __name__ == "__main__":
    main()
