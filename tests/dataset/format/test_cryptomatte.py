"""Cryptomatte files, read by another program's library and by the specification."""

from __future__ import annotations

import numpy as np
import pytest

from glassware.core.errors import InputError
from glassware.dataset.format.cryptomatte import murmur3_32, name_hash, read_cryptomatte, write_cryptomatte
from glassware.dataset.format.exr import exr_attributes, read_exr, write_exr


@pytest.fixture
def coverage():
    """Fractions of nine objects, which are sixteenths and at most 1 in all; some pixels show none."""
    rng = np.random.default_rng(3)
    counts = rng.multinomial(16, np.full(10, 0.1), size=(6, 8))[..., :9]
    counts[0, 0] = 0
    return {f"object-{i:02d}": (counts[..., i] / 16.0).astype(np.float32) for i in range(9)}


# Of the author's test program and of the page on MurmurHash of Wikipedia.
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("", 0),
        ("test", 0xBA6BD213),
        ("Hello, world!", 0xC0363E43),
        ("The quick brown fox jumps over the lazy dog", 0x2E4FF723),
    ],
)
def test_the_hash_is_murmur_hash_3(text, expected):
    assert murmur3_32(text.encode()) == expected


def test_ids_are_finite_normal_floats():
    bits = np.array([name_hash(f"name {i}") for i in range(3000)], np.uint32)
    exponents = bits >> 23 & 0xFF
    assert exponents.min() > 0
    assert exponents.max() < 255


def test_another_library_reads_the_same_mattes(coverage, tmp_path):
    library = pytest.importorskip("cryptomatte_api")
    path = tmp_path / "cryptomatte.exr"
    write_cryptomatte(path, coverage, (6, 8))
    (found,) = library.Cryptomatte.load(str(path))
    assert (found.width(), found.height()) == (8, 6)
    masks = found.masks(sorted(coverage))
    assert set(masks) == set(coverage)
    for name, expected in coverage.items():
        np.testing.assert_allclose(masks[name], expected, atol=1e-6)


def test_ranks_descend_and_attributes_name_the_layer(coverage, tmp_path):
    path = tmp_path / "cryptomatte.exr"
    write_cryptomatte(path, coverage, (6, 8))
    channels = read_exr(path)
    ranks = np.stack([channels[f"CryptoObject{level:02d}.{letter}"] for level in range(3) for letter in "GA"])
    assert (np.diff(ranks, axis=0) <= 0.0).all()
    assert all(values.dtype == np.float32 for values in channels.values())
    # The key of a layer is the first seven digits of the hash of its name.
    key = f"cryptomatte/{murmur3_32(b'CryptoObject'):08x}"[:19]
    attributes = exr_attributes(path)
    assert attributes[f"{key}/name"] == "CryptoObject"
    assert attributes[f"{key}/hash"] == "MurmurHash3_32"
    assert attributes[f"{key}/conversion"] == "uint32_to_float32"


def test_our_reader_returns_what_was_written(coverage, tmp_path):
    path = tmp_path / "cryptomatte.exr"
    write_cryptomatte(path, coverage, (6, 8))
    found = read_cryptomatte(path)
    assert set(found) == set(coverage)
    for name, expected in coverage.items():
        np.testing.assert_array_equal(found[name], expected)
    write_cryptomatte(path, {}, (6, 8))
    assert read_cryptomatte(path) == {}


def test_a_file_without_names_is_refused(tmp_path):
    path = tmp_path / "cryptomatte.exr"
    write_exr(path, {f"CryptoObject00.{letter}": np.zeros((2, 2), np.float32) for letter in "RGBA"})
    with pytest.raises(InputError, match="a Cryptomatte manifest"):
        read_cryptomatte(path)
