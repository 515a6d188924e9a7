"""Report, paper, studies and leaderboard as static pages that open from disk."""
