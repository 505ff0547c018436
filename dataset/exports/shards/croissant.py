"""What shards hold, in MLCommons' Croissant 1.0: files with digests, and how records are read from them.

(docs.mlcommons.org/croissant, "Croissant Format Specification 1.0".)
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..job import Job
from .card import columns

#: The terms of the specification, as its "@context" has to name them.
_CONTEXT: dict[str, Any] = {
    "@language": "en",
    "@vocab": "https://schema.org/",
    "citeAs": "cr:citeAs",
    "column": "cr:column",
    "conformsTo": "dct:conformsTo",
    "cr": "http://mlcommons.org/croissant/",
    "rai": "http://mlcommons.org/croissant/RAI/",
    "data": {"@id": "cr:data", "@type": "@json"},
    "dataType": {"@id": "cr:dataType", "@type": "@vocab"},
    "dct": "http://purl.org/dc/terms/",
    "equivalentProperty": "cr:equivalentProperty",
    "examples": {"@id": "cr:examples", "@type": "@json"},
    "extract": "cr:extract",
    "field": "cr:field",
    "fileProperty": "cr:fileProperty",
    "fileObject": "cr:fileObject",
    "fileSet": "cr:fileSet",
    "format": "cr:format",
    "includes": "cr:includes",
    "isLiveDataset": "cr:isLiveDataset",
    "jsonPath": "cr:jsonPath",
    "key": "cr:key",
    "md5": "cr:md5",
    "parentField": "cr:parentField",
    "path": "cr:path",
    "recordSet": "cr:recordSet",
    "references": "cr:references",
    "regex": "cr:regex",
    "repeated": "cr:repeated",
    "replace": "cr:replace",
    "samplingRate": "cr:samplingRate",
    "sc": "https://schema.org/",
    "separator": "cr:separator",
    "source": "cr:source",
    "subField": "cr:subField",
    "transform": "cr:transform",
}
#: Media types and Croissant's types of contents, by the last ending of a member.
_CONTENTS = {
    "png": ("image/png", "sc:ImageObject"),
    "json": ("application/json", "sc:Text"),
    "exr": ("image/x-exr", "sc:Text"),
}


def croissant(job: Job, digests: Mapping[str, str]) -> dict[str, Any]:
    """Return the description of an export in shards.

    Parameters
    ----------
    job : Job
        The export.
    digests : mapping of str to str
        SHA-256 of each shard, by its path in the export.
    """
    head = job.dataset.head
    files = [_file(name, digest) for name, digest in digests.items()]
    sets, records = [], []
    for config, kinds in columns(job).items():
        shards = [{"@id": name} for name in digests if name.startswith(f"{config}/")]
        for member in (name for name in kinds if not name.startswith("__")):
            media, content = _CONTENTS[member.rsplit(".", 1)[1]]
            name = f"{config}-{member.replace('.', '-')}"
            sets.append(
                {
                    "@type": "cr:FileSet",
                    "@id": name,
                    "name": name,
                    "containedIn": shards,
                    "encodingFormat": media,
                    "includes": f"*.{member}",
                }
            )
            if media != "image/x-exr":  # which no reader of Croissant decodes
                records.append(_records(name, member, content))
    described = {
        "@context": _CONTEXT,
        "@type": "sc:Dataset",
        "conformsTo": "http://mlcommons.org/croissant/1.0",
        "name": head.name,
        "description": f"Transparent objects, rendered and labelled by glassware (seed {head.seed}).",
        "version": "1.0.0",
        "distribution": files + sets,
        "recordSet": records,
    }
    if head.assets:
        described["isBasedOn"] = [
            {"@type": "sc:CreativeWork", "name": asset.source, "license": asset.licence, "identifier": asset.sha256}
            for asset in head.assets
        ]
    return described | ({"license": job.options.licence} if job.options.licence else {})


def _file(name: str, digest: str) -> dict[str, Any]:
    return {
        "@type": "cr:FileObject",
        "@id": name,
        "name": name,
        "contentUrl": name,
        "encodingFormat": "application/x-tar",
        "sha256": digest,
    }


def _records(name: str, member: str, content: str) -> dict[str, Any]:
    """Return a set of records of one kind of member: the key of the sample, and what the file holds."""
    identity, ending = f"{name}-records", re.escape(member)
    key = _field(f"{identity}/key", "sc:Text", name, "filename")
    key["source"]["transform"] = {"regex": rf"^(.+)\.{ending}$"}
    fields = [key, _field(f"{identity}/content", content, name, "content")]
    return {
        "@type": "cr:RecordSet",
        "@id": identity,
        "name": identity,
        "key": {"@id": key["@id"]},
        "field": fields,
    }


def _field(identity: str, kind: str, files: str, what: str) -> dict[str, Any]:
    source: dict[str, Any] = {"fileSet": {"@id": files}, "extract": {"fileProperty": what}}
    return {"@type": "cr:Field", "@id": identity, "name": identity, "dataType": kind, "source": source}
