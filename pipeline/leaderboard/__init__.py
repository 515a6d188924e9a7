"""The leaderboard: committed lines of solvers on suites of hard poses, judged again."""
