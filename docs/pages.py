"""What pages ask their readers to type: the commands of ```sh blocks, one a line, comments taken off."""
import re


def commands_of(page):
    """Lines of shell of the page's ```sh blocks, in order; a backslash at its end continues a line."""
    blocks = re.findall(r"^```sh\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL)
    joined = [re.sub(r"\s*\\\n\s*", " ", block) for block in blocks]
    lines = [re.sub(r"\s+#\s.*$", "", line).strip() for block in joined for line in block.splitlines()]
    return [line for line in lines if line]
