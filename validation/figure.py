"""Makes figure.png of cases from the figures that `rsph validate` left in out/validation.

    python validation/figure.py            # all cases that have drawn one
    python validation/figure.py tensile    # one

Needs cairosvg and pillow. Cases with a figure.py or picture.py of their own keep what that makes.
"""

import io
import sys
from pathlib import Path

import cairosvg
from PIL import Image

HERE = Path(__file__).parent
DRAWN = HERE.parent / "out" / "validation"
WIDEST = 1320


def main(names: list[str]) -> None:
    for case in sorted(p.name for p in HERE.iterdir() if (p / "README.md").is_file()):
        svg = DRAWN / f"{case}.svg"
        own = [p for p in (HERE / case).glob("*.py") if p.name in ("figure.py", "picture.py")]
        if (names and case not in names) or own or not svg.is_file():
            continue
        picture = Image.open(io.BytesIO(cairosvg.svg2png(url=str(svg), background_color="white")))
        picture = picture.convert("RGB")
        if picture.width > WIDEST:
            height = round(picture.height * WIDEST / picture.width)
            picture = picture.resize((WIDEST, height), Image.Resampling.LANCZOS)
        path = HERE / case / "figure.png"
        # 128 colours are enough for lines and shades, and make a small file.
        picture.quantize(128, dither=Image.Dither.NONE).save(path, optimize=True)
        print(f"{path.relative_to(HERE.parent)}: {path.stat().st_size // 1000} kB")


if __name__ == "__main__":
    main(sys.argv[1:])
