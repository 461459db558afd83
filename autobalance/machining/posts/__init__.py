"""Dialects of NC programs, one file each; a new one registers here."""

from __future__ import annotations

from autobalance.errors import JobError
from autobalance.machining.posts.post import Fanuc, LinuxCnc, Post

POSTS: dict[str, type[Post]] = {post.name: post for post in (LinuxCnc, Fanuc)}


def post_named(name: str) -> type[Post]:
    """Return the post of a name.

    Raises
    ------
    JobError If the post is unknown.
    """
    if name not in POSTS:
        raise JobError(f'machine.post is "{name}"; expected one of {", ".join(POSTS)}')
    return POSTS[name]
